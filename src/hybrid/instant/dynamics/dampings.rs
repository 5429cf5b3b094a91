//! Damping of degrees of freedom, by their own dampers and by motors.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Motor;

/// The freedoms that joint dampers and these motors damp, with the sum of their coefficients [N m s/rad or N s/m].
pub(crate) fn dampings<'m>(mechanism: &Mechanism, motors: impl Iterator<Item = &'m Motor>) -> Vec<(usize, f64)> {
    let dampers = mechanism.forces.joint_dampers.iter().map(|damper| (damper.freedom, damper.coefficient));
    let motors = motors.map(|motor| (motor.coordinate.freedom, motor.law.gains().1));
    let mut all: Vec<(usize, f64)> = Vec::new();
    for (freedom, damping) in dampers.chain(motors).filter(|(_, damping)| *damping > 0.0) {
        match all.iter_mut().find(|(known, _)| *known == freedom) {
            Some((_, sum)) => *sum += damping,
            None => all.push((freedom, damping)),
        }
    }
    all
}

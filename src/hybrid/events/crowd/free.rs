//! The rates that trees would have without contacts.
//!
//! ```text
//!     v_f = v + b M̃⁻¹ (M a + e),    M̃ = M + b D + b² K          b: half a step to its end (A), a whole one for the rates there (B)
//! ```
//!
//! a are the accelerations without rows, D and K the dampings and stiffnesses of the freedoms, e what these add in the time b (s).

use crate::crowd::trees::Trees;
use crate::events::crowd::contacts::{Scene, has_row};
use crate::events::crowd::resting::Resting;
use crate::events::crowd::step::{Crowd, Forces};
use crate::mechanism::motion::state::State;

impl Crowd {
    /// Dampings and stiffnesses of the freedoms.
    pub(super) fn soften(&mut self, scene: Scene) {
        self.damping.fill(0.0);
        self.stiffness.fill(0.0);
        for damper in &scene.whole.forces.joint_dampers {
            self.damping[damper.freedom] += damper.coefficient;
        }
        for spring in &scene.whole.forces.joint_springs {
            self.stiffness[spring.coordinate.freedom] += spring.stiffness.max(0.0);
        }
        for motor in scene.elements.motors.iter().filter(|motor| motor.period == 0.0 && !has_row(motor)) {
            let (stiffness, damping) = motor.law.gains();
            self.stiffness[motor.coordinate.freedom] += stiffness;
            self.damping[motor.coordinate.freedom] += damping;
        }
    }

    /// v_f of (A): half a step under the forces at the start, with dampers and springs at its middle.
    pub(super) fn free_to_move(&mut self, start: &State, half: f64) -> Option<()> {
        let Crowd { trees, damping, stiffness, free, acceleration, resting, .. } = self;
        let change = |freedom: usize| -(half * stiffness[freedom] * start.velocity[freedom]);
        let soft = [damping.as_slice(), stiffness.as_slice()];
        free_rates((trees, resting), soft, half, acceleration, change, &start.velocity, free)
    }

    /// v_f of (B): a whole step under the forces at its middle, with dampers at its end.
    pub(super) fn free_to_settle(
        &mut self,
        start: &State,
        displacement: &[f64],
        step: f64,
        forces: Forces,
    ) -> Option<()> {
        let Crowd { trees, damping, stiffness, free, acceleration, efforts, middle, resting, .. } = self;
        forces(middle.as_mut()?, acceleration, efforts);
        stiffness.fill(0.0);
        let change = |freedom: usize| damping[freedom] * (displacement[freedom] - start.velocity[freedom]);
        let soft = [damping.as_slice(), stiffness.as_slice()];
        free_rates((trees, resting), soft, step, acceleration, change, &start.velocity, free)
    }
}

/// v_f = v + b M̃⁻¹ (M a + e): the rates of trees after a time b (s) under accelerations a and changes e of the efforts of dampers D and springs K, which
/// act in it, and zero for those that sleep; `None` where M̃ is singular.
fn free_rates(
    (trees, resting): (&mut Trees, &Resting),
    [damping, stiffness]: [&[f64]; 2],
    time: f64,
    accelerations: &[f64],
    change: impl Fn(usize) -> f64,
    velocity: &[f64],
    free: &mut [f64],
) -> Option<()> {
    for (number, tree) in trees.trees.iter_mut().enumerate() {
        if resting.asleep.has(number) {
            tree.all.iter().for_each(|&freedom| free[freedom] = 0.0);
            continue;
        }
        if !tree.factor(time, damping, stiffness) {
            return None;
        }
        if tree.all.iter().any(|&freedom| damping[freedom] + stiffness[freedom] > 0.0) {
            let own: Vec<f64> = tree.freedoms.iter().map(|&freedom| accelerations[freedom]).collect();
            let mut efforts = vec![0.0; own.len()];
            tree.add_mass(&own, &mut efforts);
            tree.gather(&change, &mut efforts);
            tree.solve(&mut efforts);
            for (rate, &freedom) in efforts.iter().zip(&tree.freedoms) {
                free[freedom] = velocity[freedom] + time * rate;
            }
        } else {
            for &freedom in &tree.freedoms {
                free[freedom] = velocity[freedom] + time * accelerations[freedom];
            }
        }
        tree.complete(free);
    }
    Some(())
}

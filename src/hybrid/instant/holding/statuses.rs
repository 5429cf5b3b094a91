//! Whether joints of a stored state are on a limit or held by friction.
//!
//! A joint that is held has a rate of exactly zero. A joint that moves has that at single instants only, so the rate decides.

use crate::instant::holding::elements::Elements;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::event::JointStatus;
use crate::mechanism::motion::state::State;

/// The status of the joint of each body in a state, with the efforts of the motors: one entry a motor of the mechanism [N m or N], as far as they are
/// known.
pub fn joint_statuses(mechanism: &Mechanism, state: &State, motors: &[Option<f64>]) -> Vec<JointStatus> {
    let elements = Elements::new(mechanism);
    let mut statuses: Vec<JointStatus> = (0..mechanism.bodies.len())
        .map(|body| {
            let of = elements.joints.iter().find_map(|joint| {
                let held = (joint.rate(state) == 0.0).then(|| joint.side(joint.position(state)));
                joint.status(body, held)
            });
            of.unwrap_or_default()
        })
        .collect();
    for (motor, effort) in elements.motors.iter().zip(motors) {
        statuses[motor.coordinate.body].effort = *effort;
    }
    statuses
}

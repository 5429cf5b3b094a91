//! A top that spins faster and faster: many turns within a step.

use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::{Body, Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::GRAVITY;
use nalgebra::Vector3;

const RATES: [f64; 8] = [1.5, 5.0, 15.0, 50.0, 150.0, 500.0, 1500.0, 5000.0];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "spin_rate",
        title: "A fast top",
        scene: "The heavy top of the literature (15 kg, 1 m from its fixed point), spinning about its own axis; the last column \
                but one turns it by a third of a radian a step at 1500 rad/s.",
        axis: "spin [rad/s]",
        difficulties: vec!["1.5", "5", "15", "50", "150", "500", "1500", "5000"],
        steps: steps(0.1, 1e-4, 10),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let joint = Joint::new("pivot", JointKind::Spherical, Pose::identity(), Pose::translation(0.0, -1.0, 0.0));
    let inertia = Vector3::new(0.234375, 0.46875, 0.234375);
    let top = Body { name: "top".to_string(), parent: None, mass: 15.0, inertia, joint };
    let mechanism = Mechanism::new("spin_rate", GRAVITY, vec![top])?;
    let mut start = State::zero(&mechanism);
    // The start of the benchmark: a tenth of a turn of precession is in it.
    start.velocity.copy_from_slice(&[0.0, RATES[place], -0.030_769_2 * RATES[place]]);
    Ok(Case::new(mechanism, start, 0.5))
}

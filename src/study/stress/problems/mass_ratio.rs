//! A heavy tip on a light chain: iterative solvers fail to converge, and light links vibrate.

use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, chain};
use nalgebra::Vector3;

const RATIOS: [f64; 9] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "mass_ratio",
        title: "A heavy tip on a light chain",
        scene: "Five links of 0.2 m, hinged about y and x by turns, swing down from 40°. All weigh 1 kg but the last.",
        axis: "mass of the last link / mass of the others",
        difficulties: vec!["1", "10", "10²", "10³", "10⁴", "10⁵", "10⁶", "10⁷", "10⁸"],
        steps: steps(0.2, 2e-4, 10),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let mut bodies = chain(5, 0.2, 0.04, 1.0, -Vector3::z(), [Vector3::y(), Vector3::x()]);
    if let Some(tip) = bodies.last_mut() {
        tip.mass *= RATIOS[place];
        tip.inertia *= RATIOS[place];
    }
    let mechanism = Mechanism::new("mass_ratio", GRAVITY, bodies)?;
    let mut start = State::zero(&mechanism);
    start.position.copy_from_slice(&[0.7, 0.1, 0.0, 0.05, 0.0]);
    Ok(Case::new(mechanism, start, 2.0))
}

//! A chain that falls from the level: it cracks like a whip.

use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, chain};
use nalgebra::Vector3;

const LENGTHS: [usize; 7] = [3, 5, 10, 20, 50, 100, 200];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "violent_motion",
        title: "A chain that falls and cracks",
        scene: "Links of 0.1 m and 0.1 kg stretched out level, every second hinge a twist joint that starts at 0.4 rad; they fall and the end cracks.",
        axis: "number of links",
        difficulties: vec!["3", "5", "10", "20", "50", "100", "200"],
        steps: steps(0.05, 5e-4, 8),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let bodies = chain(LENGTHS[place], 0.1, 0.02, 0.1, Vector3::x(), [Vector3::y(), Vector3::x()]);
    let mechanism = Mechanism::new("violent_motion", GRAVITY, bodies)?;
    let mut start = State::zero(&mechanism);
    start.position.iter_mut().skip(1).step_by(2).for_each(|twist| *twist = 0.4);
    Ok(Case::new(mechanism, start, 1.5))
}

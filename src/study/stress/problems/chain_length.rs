//! Long chains: cost and accuracy of a method with many bodies.

use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{BUDGET, Case, Problem, steps};
use crate::stress::problems::{GRAVITY, chain};
use nalgebra::Vector3;

const LENGTHS: [usize; 11] = [2, 5, 10, 20, 50, 100, 200, 500, 1000, 3000, 10_000];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "chain_length",
        title: "Long chains",
        scene: "Links of 0.1 m and 0.1 kg, hinged about y and x by turns, hang straight and swing down from 45°.",
        axis: "number of links",
        difficulties: vec!["2", "5", "10", "20", "50", "100", "200", "500", "1000", "3000", "10 000"],
        steps: steps(0.1, 5e-4, 8),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let bodies = chain(LENGTHS[place], 0.1, 0.02, 0.1, -Vector3::z(), [Vector3::y(), Vector3::x()]);
    let mechanism = Mechanism::new("chain_length", GRAVITY, bodies)?;
    let mut start = State::zero(&mechanism);
    start.position[0] = std::f64::consts::FRAC_PI_4;
    let mut case = Case::new(mechanism, start, 1.0);
    // The cost of a step grows with the chain.
    case.budget = (4e-4 * LENGTHS[place] as f64).max(BUDGET);
    Ok(case)
}

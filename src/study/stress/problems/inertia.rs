//! Inertias that are nearly zero, zero, or impossible for a body.

use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, Truth, steps};
use crate::stress::problems::{GRAVITY, chain};
use nalgebra::Vector3;

/// Moment about the link's own axis over the moment about the others. A body has at most 2; the last inertia is zero.
const RATIOS: [f64; 10] = [1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-12, 3.0, 10.0, 100.0, 0.0];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "inertia",
        title: "Nearly no inertia, and impossible ones",
        scene: "Four links along x, every second hinge twists a link about its own axis. No body has a moment that is larger than \
                the sum of the two others (3 and more); with none at all nothing says how the link twists, and there is no answer.",
        axis: "moment about own axis / others",
        difficulties: vec![
            "1",
            "10⁻²",
            "10⁻⁴",
            "10⁻⁶",
            "10⁻⁸",
            "10⁻¹²",
            "3 (no body)",
            "10 (no body)",
            "100 (no body)",
            "0 (no answer)",
        ],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let mut bodies = chain(4, 0.2, 0.04, 0.5, Vector3::x(), [Vector3::y(), Vector3::x()]);
    for body in &mut bodies {
        body.inertia.x = RATIOS[place] * body.inertia.y;
    }
    let mechanism = Mechanism::new("inertia", GRAVITY, bodies)?;
    let mut start = State::zero(&mechanism);
    start.position.copy_from_slice(&[0.0, 0.4, 0.3, 0.4]);
    let mut case = Case::new(mechanism, start, 1.0);
    if RATIOS[place] == 0.0 {
        // The fourth hinge turns the last link about the axis on which all its mass lies.
        case.truth = Truth::None("the twist of a link without inertia is not determined");
    }
    Ok(case)
}

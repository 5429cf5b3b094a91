//! A damper that is hard enough to almost lock its joint.

use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::forces::PointSpring;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, chain};
use nalgebra::Vector3;

const DAMPINGS: [f64; 7] = [1.0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "stiff_damper",
        title: "A hard damper",
        scene: "A double pendulum (0.5 m, 1 kg each), released level; a damper from its tip to the ceiling lets the tip move on a circle \
                only.",
        axis: "damping [N s/m]",
        difficulties: vec!["1", "10²", "10⁴", "10⁶", "10⁸", "10¹⁰", "10¹²"],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let bodies = chain(2, 0.5, 0.05, 1.0, Vector3::x(), [Vector3::y(), Vector3::y()]);
    let mut mechanism = Mechanism::new("stiff_damper", GRAVITY, bodies)?;
    mechanism.forces.point_springs.push(PointSpring {
        name: "damper".to_string(),
        a: Attachment { body: None, frame: Pose::translation(0.8, 0.0, 1.0) },
        b: Attachment { body: Some(1), frame: Pose::translation(0.25, 0.0, 0.0) },
        stiffness: 0.0,
        damping: DAMPINGS[place],
        rest_length: 1.0,
    });
    let mut start = State::zero(&mechanism);
    start.position.copy_from_slice(&[0.2, -0.5]);
    Ok(Case::new(mechanism, start, 1.0))
}

//! A pendulum whose string is a spring: the stiffer it is, the more it acts as a rod, and the faster the vibration that should not be visible.

use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::forces::PointSpring;
use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::{Body, Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, box_inertia};
use nalgebra::Vector3;

const STIFFNESSES: [f64; 7] = [1e2, 1e4, 1e6, 1e8, 1e10, 1e12, 1e14];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "stiff_spring",
        title: "A stiff spring",
        scene: "A free box of 1 kg hangs by a corner on a spring of 1 m; released level, the spring without force.",
        axis: "stiffness [N/m]",
        difficulties: vec!["10²", "10⁴", "10⁶", "10⁸", "10¹⁰", "10¹²", "10¹⁴"],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let size = Vector3::new(0.2, 0.3, 0.4);
    let joint = Joint::new("free", JointKind::Floating, Pose::identity(), Pose::identity());
    let block = Body { name: "box".to_string(), parent: None, mass: 1.0, inertia: box_inertia(1.0, size), joint };
    let mut mechanism = Mechanism::new("stiff_spring", GRAVITY, vec![block])?;
    let at = |body, place: Vector3<f64>| Attachment { body, frame: Pose::translation(place.x, place.y, place.z) };
    let corner = Vector3::new(-0.1, 0.0, 0.0);
    mechanism.forces.point_springs.push(PointSpring {
        name: "string".to_string(),
        a: at(None, Vector3::zeros()),
        b: at(Some(0), corner),
        stiffness: STIFFNESSES[place],
        damping: 0.0,
        rest_length: 1.0,
    });
    let mut start = State::zero(&mechanism);
    start.position[0] = 1.1;
    Ok(Case::new(mechanism, start, 1.0))
}

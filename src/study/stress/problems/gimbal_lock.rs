//! A top in gimbals that start near their locked position, where two of the three axes coincide.

use crate::mechanism::description::joint::{Joint, JointKind, Pose, wxyz_from_rotation};
use crate::mechanism::description::mechanism::{Body, Mechanism, MechanismError};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, Truth, steps};
use crate::stress::problems::{GRAVITY, box_inertia, frame, set_ball};
use nalgebra::Vector3;

/// Angle from the locked position (rad); the first is a ball joint, which knows no such thing.
const ANGLES: [Option<f64>; 8] =
    [None, Some(1.0), Some(0.1), Some(1e-2), Some(1e-3), Some(1e-4), Some(1e-6), Some(1e-8)];

const MASS: f64 = 1.0;
const SIZE: Vector3<f64> = Vector3::new(0.2, 0.3, 0.8);
const ARM: f64 = 0.4;

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "gimbal_lock",
        title: "Gimbals near lock",
        scene: "A box on a fixed point, in three hinges with massless rings between them: how coordinates of three angles see a \
                rotation. The angle between the first and the last axis is the difficulty; the answer is the motion on a ball joint.",
        axis: "angle from lock [rad]",
        difficulties: vec!["ball joint", "1", "10⁻¹", "10⁻²", "10⁻³", "10⁻⁴", "10⁻⁶", "10⁻⁸"],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn ball() -> Result<Mechanism, MechanismError> {
    let joint = Joint::new("pivot", JointKind::Spherical, Pose::identity(), Pose::translation(0.0, 0.0, ARM));
    let top = Body { name: "top".to_string(), parent: None, mass: MASS, inertia: box_inertia(MASS, SIZE), joint };
    Mechanism::new("ball", GRAVITY, vec![top])
}

fn gimbals() -> Result<Mechanism, MechanismError> {
    let origin = Vector3::zeros();
    let ring = |name: &str, parent, axis| Body {
        name: name.to_string(),
        parent,
        mass: 0.0,
        inertia: Vector3::zeros(),
        joint: Joint::new(name, JointKind::Revolute, frame(origin, axis), frame(origin, axis)),
    };
    let spin = Joint::new(
        "inner",
        JointKind::Revolute,
        frame(origin, Vector3::z()),
        frame(Vector3::new(0.0, 0.0, ARM), Vector3::z()),
    );
    let top =
        Body { name: "top".to_string(), parent: Some(1), mass: MASS, inertia: box_inertia(MASS, SIZE), joint: spin };
    Mechanism::new(
        "gimbals",
        GRAVITY,
        vec![ring("outer", None, Vector3::z()), ring("middle", Some(0), Vector3::x()), top],
    )
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let rings = gimbals()?;
    let mut start = State::zero(&rings);
    // The outer and the inner axis coincide where the middle hinge is at zero; it moves that way.
    start.position.copy_from_slice(&[0.3, ANGLES[place].unwrap_or(0.5), 0.2]);
    start.velocity.copy_from_slice(&[1.0, -0.5, 2.0]);
    let Some(top) = body_states(&rings, &start).last().copied() else {
        return Ok(Case::new(rings, start, 1.0));
    };
    let free = ball()?;
    let mut free_start = State::zero(&free);
    let spin = top.rotation.transpose() * top.angular_velocity;
    set_ball(&mut free_start, wxyz_from_rotation(&top.rotation), spin);
    Ok(match ANGLES[place] {
        None => Case::new(free, free_start, 1.0),
        Some(_) => {
            let truth = Truth::Same(Box::new((free, free_start)));
            Case { truth, watched: 1, ..Case::new(rings, start, 1.0) }
        }
    })
}

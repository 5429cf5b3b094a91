//! The mechanisms that tests and benches share, each with an initial state and, where there is one, an answer.
//!
//! Lengths are in metres, masses in kg, angles in radians, times in seconds; gravity is 9.81 m/s² downwards unless a line
//! says otherwise.

// Every program of tests and every bench compiles its own copy of this module and uses some of it.
#![allow(dead_code, unused_imports)]

mod benchmarks;
mod forces;

pub use benchmarks::*;
pub use forces::*;

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::joint::{FreeRotation, Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// A mechanism and the state a run starts from.
pub struct Model {
    pub mechanism: Mechanism,
    pub state: State,
}

impl Model {
    /// The maximal-coordinate state at the start.
    pub fn bodies(&self) -> Vec<BodyState> {
        body_states(&self.mechanism, &self.state)
    }
}

/// Standard gravity of these models.
pub fn gravity() -> Vector3<f64> {
    Vector3::new(0.0, 0.0, -9.81)
}

/// A frame at `place` whose z axis, the joint's axis, points along `axis`.
pub fn frame(place: Vector3<f64>, axis: Vector3<f64>) -> Pose {
    let turn = Rotation3::rotation_between(&Vector3::z(), &axis)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    Pose::from_parts(Translation3::from(place), turn)
}

/// A frame at `place` turned by the rotation vector `turn`.
pub fn turned_frame(place: Vector3<f64>, turn: Vector3<f64>) -> Pose {
    Pose::from_parts(Translation3::from(place), Rotation3::new(turn))
}

/// Principal moments of a uniform box about its centre: `m/12 (b² + c²)` and so on.
pub fn box_inertia(mass: f64, size: Vector3<f64>) -> Vector3<f64> {
    let square = size.component_mul(&size);
    Vector3::new(square.y + square.z, square.z + square.x, square.x + square.y) * (mass / 12.0)
}

/// A body from its parts.
pub fn body(name: &str, parent: Option<usize>, mass: f64, inertia: Vector3<f64>, joint: Joint) -> Body {
    Body { name: name.to_string(), parent, mass, inertia, joint }
}

/// A model at rest at zero displacement.
fn model(name: &str, gravity: Vector3<f64>, bodies: Vec<Body>) -> Model {
    let mechanism = Mechanism::new(name, gravity, bodies).expect("the models of this module are well formed");
    let state = State::zero(&mechanism);
    Model { mechanism, state }
}

/// Gives every joint a displacement and a rate of order one half, all different and none special.
fn set_generic_state(model: &mut Model) {
    let wave = |index: usize, phase: f64| 0.5 * (1.7 * index as f64 + phase).sin();
    for body in &model.mechanism.bodies {
        let joint = &body.joint;
        let position = &mut model.state.position[joint.position_range()];
        let first = joint.position_index;
        for (offset, entry) in position.iter_mut().enumerate() {
            *entry += wave(first + offset, 0.6);
        }
        if joint.kind.rotation() == FreeRotation::Ball {
            let quaternion = &mut position[joint.kind.translation_axes().len()..];
            let norm = quaternion.iter().map(|component| component * component).sum::<f64>().sqrt();
            quaternion.iter_mut().for_each(|component| *component /= norm);
        }
    }
    for (index, entry) in model.state.velocity.iter_mut().enumerate() {
        *entry = 2.0 * wave(index, 2.1);
    }
}

/// Two 1 m boxes: a revolute joint about y, then one about x, off the centre lines, released at rest from
/// (1.2, −0.7) rad. The smallest truly spatial mechanism: the two rotations do not commute.
pub fn double_pendulum() -> Model {
    let size = Vector3::new(0.06, 0.12, 1.0);
    let inertia = box_inertia(1.0, size);
    let centre = [Vector3::new(0.01, 0.02, -0.5), Vector3::new(0.03, -0.01, -0.5)];
    let elbow = Vector3::new(0.04, 0.09, -1.0);
    let shoulder_joint = Joint::new(
        "shoulder",
        JointKind::Revolute,
        frame(Vector3::zeros(), Vector3::y()),
        frame(-centre[0], Vector3::y()),
    );
    let elbow_joint = Joint::new(
        "elbow",
        JointKind::Revolute,
        frame(elbow - centre[0], Vector3::x()),
        frame(-centre[1], Vector3::x()),
    );
    let mut model = model(
        "double_pendulum",
        gravity(),
        vec![body("upper", None, 1.0, inertia, shoulder_joint), body("lower", Some(0), 1.0, inertia, elbow_joint)],
    );
    model.state.position = vec![1.2, -0.7];
    model
}

/// One box on a spherical joint, with a spin: a pendulum that leaves every plane.
pub fn spatial_pendulum() -> Model {
    let joint = Joint::new(
        "pivot",
        JointKind::Spherical,
        turned_frame(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.4, -0.3, 0.2)),
        turned_frame(Vector3::new(0.03, 0.05, 0.6), Vector3::new(-0.2, 0.5, 0.1)),
    );
    let inertia = box_inertia(2.0, Vector3::new(0.2, 0.3, 1.0));
    let mut model = model("spatial_pendulum", gravity(), vec![body("bob", None, 2.0, inertia, joint)]);
    set_generic_state(&mut model);
    model
}

/// A floating base with every other kind of joint on it: a slider that carries a hinge, a ball and a hinge.
pub fn floating_tree() -> Model {
    let x = Vector3::x();
    let base = Joint::new(
        "base",
        JointKind::Floating,
        turned_frame(Vector3::new(0.2, 0.1, 1.0), Vector3::new(0.3, 0.2, -0.1)),
        turned_frame(Vector3::new(0.05, -0.02, 0.03), Vector3::new(-0.1, 0.2, 0.3)),
    );
    let rail = Joint::new(
        "rail",
        JointKind::Prismatic,
        turned_frame(Vector3::new(0.3, 0.0, 0.1), Vector3::new(0.2, 1.1, 0.0)),
        turned_frame(Vector3::new(-0.1, 0.02, 0.0), Vector3::new(0.3, -0.4, 0.5)),
    );
    let wrist = Joint::new(
        "wrist",
        JointKind::Revolute,
        turned_frame(Vector3::new(0.15, 0.0, 0.05), Vector3::new(-0.6, 0.3, 0.2)),
        turned_frame(Vector3::new(-0.12, 0.0, 0.01), Vector3::new(0.1, 0.8, 0.0)),
    );
    let ball = Joint::new(
        "ball",
        JointKind::Spherical,
        turned_frame(Vector3::new(-0.3, 0.1, 0.0), Vector3::new(0.0, 0.4, 0.9)),
        turned_frame(Vector3::new(0.0, 0.2, 0.0), Vector3::new(0.5, 0.0, -0.3)),
    );
    let hip = Joint::new(
        "hip",
        JointKind::Revolute,
        frame(Vector3::new(0.0, -0.2, -0.1), x),
        turned_frame(Vector3::new(0.02, 0.0, 0.25), Vector3::new(0.2, 0.9, -0.4)),
    );
    let block = |mass: f64, a: f64, b: f64, c: f64| box_inertia(mass, Vector3::new(a, b, c));
    let mut model = model(
        "floating_tree",
        gravity(),
        vec![
            body("base", None, 5.0, block(5.0, 0.6, 0.4, 0.2), base),
            body("slider", Some(0), 1.0, block(1.0, 0.3, 0.1, 0.1), rail),
            body("hand", Some(1), 0.5, block(0.5, 0.25, 0.05, 0.1), wrist),
            body("club", Some(0), 0.8, block(0.8, 0.1, 0.4, 0.15), ball),
            body("leg", Some(0), 1.2, block(1.2, 0.1, 0.12, 0.5), hip),
        ],
    );
    set_generic_state(&mut model);
    model
}

/// `n` links of 0.1 m and 0.1 kg hanging out along x, their joints about y and x in turn, so that every second joint
/// twists a link about its own axis, whose inertia is tiny; released at rest with the twist joints at 0.4 rad.
pub fn chain(n: usize) -> Model {
    let half = Vector3::new(0.05, 0.0, 0.0);
    // Twisting this box takes thirteen times less than turning it about the other axes.
    let inertia = box_inertia(0.1, Vector3::new(0.1, 0.02, 0.02));
    let bodies = (0..n)
        .map(|index| {
            let axis = if index % 2 == 0 { Vector3::y() } else { Vector3::x() };
            let on_parent = if index == 0 { Vector3::zeros() } else { half };
            let joint = Joint::new(
                &format!("joint{}", index + 1),
                JointKind::Revolute,
                frame(on_parent, axis),
                frame(-half, axis),
            );
            body(&format!("link{}", index + 1), index.checked_sub(1), 0.1, inertia, joint)
        })
        .collect();
    let mut model = model(&format!("chain_{n}"), gravity(), bodies);
    for (index, angle) in model.state.position.iter_mut().enumerate() {
        *angle = if index % 2 == 0 { 0.0 } else { 0.4 };
    }
    model
}

/// Every joint kind.
pub const JOINT_KINDS: [JointKind; 5] =
    [JointKind::Revolute, JointKind::Prismatic, JointKind::Planar, JointKind::Spherical, JointKind::Floating];

/// Every joint kind twice in a row, mixtures, branches and bodies that never turn. The literal scheme needs Σ to be invertible, so there is no
/// heavy top.
pub fn every_model() -> Vec<Model> {
    let mut all: Vec<Model> = JOINT_KINDS.into_iter().map(one_joint).collect();
    all.extend([double_pendulum(), spatial_pendulum(), floating_tree()]);
    all
}

/// A chain of two bodies with the same kind of joint twice, on frames that are aligned with nothing, in a generic state.
pub fn one_joint(kind: JointKind) -> Model {
    let first = Joint::new(
        "first",
        kind,
        turned_frame(Vector3::new(0.2, -0.1, 0.3), Vector3::new(0.5, -0.4, 0.3)),
        turned_frame(Vector3::new(0.1, 0.2, 0.4), Vector3::new(-0.3, 0.6, 0.7)),
    );
    let second = Joint::new(
        "second",
        kind,
        turned_frame(Vector3::new(-0.1, 0.15, -0.5), Vector3::new(0.9, 0.2, -0.5)),
        turned_frame(Vector3::new(0.05, -0.1, 0.35), Vector3::new(-0.7, -0.2, 0.4)),
    );
    let mut model = model(
        kind.name(),
        gravity(),
        vec![
            body("inner", None, 2.0, box_inertia(2.0, Vector3::new(0.3, 0.5, 0.9)), first),
            body("outer", Some(0), 1.0, box_inertia(1.0, Vector3::new(0.4, 0.3, 0.7)), second),
        ],
    );
    set_generic_state(&mut model);
    model
}

/// Largest distance between two states: metres, rotation-matrix entries.
pub fn pose_distance(a: &[BodyState], b: &[BodyState]) -> f64 {
    let of_body =
        |(a, b): (&BodyState, &BodyState)| (a.position - b.position).amax().max((a.rotation - b.rotation).amax());
    a.iter().zip(b).map(of_body).fold(0.0, f64::max)
}

/// Largest distance between the velocities of two states: m/s, rad/s.
pub fn velocity_distance(a: &[BodyState], b: &[BodyState]) -> f64 {
    let of_body = |(a, b): (&BodyState, &BodyState)| {
        (a.velocity - b.velocity).amax().max((a.angular_velocity - b.angular_velocity).amax())
    };
    a.iter().zip(b).map(of_body).fold(0.0, f64::max)
}

/// The second-moment matrix `Σ = ½ tr(J) 1 − J` of a body.
pub fn second_moments(body: &Body) -> Matrix3<f64> {
    Matrix3::from_diagonal(&(Vector3::repeat(0.5 * body.inertia.sum()) - body.inertia))
}

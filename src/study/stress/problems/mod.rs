//! The problems, one file each, and the parts of their mechanisms.

pub mod chain_length;
pub mod contact_masses;
pub mod dry_friction;
pub mod friction_cone;
pub mod gimbal_lock;
pub mod impact_speed;
pub mod inconsistent_start;
pub mod inertia;
pub mod joint_limits;
pub mod light_couplings;
pub mod long_time;
pub mod mass_ratio;
pub mod motor_gain;
pub mod over_constraint;
pub mod singular_positions;
pub mod spin_rate;
pub mod stiff_damper;
pub mod stiff_spring;
pub mod violent_motion;

use crate::mechanism::description::closure::{Attachment, Coordinate, LoopJoint, LoopKind};
use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::{Body, Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::Problem;
use nalgebra::{Rotation3, Translation3, Vector3};

impl Problem {
    /// Every problem, in the order of the page.
    pub fn all() -> Vec<Problem> {
        vec![
            mass_ratio::problem(),
            chain_length::problem(),
            spin_rate::problem(),
            stiff_spring::problem(),
            stiff_damper::problem(),
            singular_positions::problem(),
            over_constraint::problem(),
            light_couplings::problem(),
            inertia::problem(),
            gimbal_lock::problem(),
            long_time::problem(),
            inconsistent_start::problem(),
            violent_motion::problem(),
            joint_limits::problem(),
            dry_friction::problem(),
            motor_gain::problem(),
            impact_speed::problem(),
            friction_cone::problem(),
            contact_masses::problem(),
        ]
    }
}

/// Standard gravity downwards [m/s²].
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A frame at `place` (m) whose z axis (the joint axis) points along `axis`.
fn frame(place: Vector3<f64>, axis: Vector3<f64>) -> Pose {
    let turn = Rotation3::rotation_between(&Vector3::z(), &axis)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    Pose::from_parts(Translation3::from(place), turn)
}

/// Principal moments of a uniform box: `m/12 (b² + c²)` and so on [kg m²].
fn box_inertia(mass: f64, size: Vector3<f64>) -> Vector3<f64> {
    let square = size.component_mul(&size);
    Vector3::new(square.y + square.z, square.z + square.x, square.x + square.y) * (mass / 12.0)
}

/// A chain of `count` equal boxes of `length` (m), side `width` (m) and `mass` (kg), each extending along `along` from its hinge. The hinges turn
/// about the two `axes` alternately.
fn chain(count: usize, length: f64, width: f64, mass: f64, along: Vector3<f64>, axes: [Vector3<f64>; 2]) -> Vec<Body> {
    let half = along * (0.5 * length);
    let size = along.abs() * (length - width) + Vector3::repeat(width);
    (0..count)
        .map(|index| {
            let axis = axes[index % 2];
            let on_parent = if index == 0 { Vector3::zeros() } else { half };
            let joint = Joint::new(
                &format!("joint{}", index + 1),
                JointKind::Revolute,
                frame(on_parent, axis),
                frame(-half, axis),
            );
            Body {
                name: format!("link{}", index + 1),
                parent: index.checked_sub(1),
                mass,
                inertia: box_inertia(mass, size),
                joint,
            }
        })
        .collect()
}

/// Free solid bodies of these masses (kg) and shapes on a floor at z = 0, all of which may touch, with one friction and without restitution.
fn on_floor(
    gravity: Vector3<f64>,
    bodies: &[(f64, Vector3<f64>, Shape)],
    friction: f64,
) -> Result<Mechanism, MechanismError> {
    let body = |(number, (mass, inertia, _)): (usize, &(f64, Vector3<f64>, Shape))| {
        let name = format!("body{}", number + 1);
        let joint = Joint::new(&name, JointKind::Floating, Pose::identity(), Pose::identity());
        Body { name, parent: None, mass: *mass, inertia: *inertia, joint }
    };
    let mut mechanism = Mechanism::new("on_floor", gravity, bodies.iter().enumerate().map(body).collect())?;
    let collider = |name: &str, body, shape| Collider::still(name, body, Pose::identity(), shape);
    let nonsmooth = &mut mechanism.nonsmooth;
    nonsmooth.colliders.push(collider("floor", None, Shape::HalfSpace));
    for (number, (.., shape)) in bodies.iter().enumerate() {
        nonsmooth.colliders.push(collider(&format!("body{}", number + 1), Some(number), shape.clone()));
    }
    for b in 1..=bodies.len() {
        for a in 0..b {
            let number = nonsmooth.pairs.len();
            nonsmooth.pairs.push(ContactPair::without_moments(number, [a, b], friction, 0.0));
        }
    }
    Ok(mechanism)
}

/// Puts a free body at a place (m), turned about y (rad), with a velocity (m/s).
fn put(mechanism: &Mechanism, state: &mut State, body: usize, at: Vector3<f64>, turned: f64, velocity: Vector3<f64>) {
    let joint = &mechanism.bodies[body].joint;
    let position = &mut state.position[joint.position_range()];
    position[..3].copy_from_slice(at.as_slice());
    position[3..].copy_from_slice(&[(0.5 * turned).cos(), 0.0, (0.5 * turned).sin(), 0.0]);
    state.velocity[joint.velocity_range()][..3].copy_from_slice(velocity.as_slice());
}

/// The coordinate of a body's joint with one degree of freedom.
fn only_coordinate(mechanism: &Mechanism, body: usize) -> Coordinate {
    let joint = &mechanism.bodies[body].joint;
    Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
}

/// Turns z into −y, so that a positive angle lifts x towards z.
fn upward(x: f64) -> Pose {
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    Pose::from_parts(Translation3::new(x, 0.0, 0.0), turn)
}

/// `count` parallelograms of uniform rods (1 m, 1 kg) in a row, closed by revolute joints. Each loop has five equations, three of them redundant.
/// The cranks start upright and their tips move at 1 m/s. Benchmark A02 of the IFToMM library.
fn four_bars(count: usize) -> Result<(Mechanism, State), MechanismError> {
    // A rod is 4 cm thick. Its inertia about its own axis has no effect, but methods that invert it need it.
    let rod = |name: String, parent: Option<usize>, hinge_at: f64| Body {
        parent,
        mass: 1.0,
        inertia: Vector3::new(2.7e-4, 1.0 / 12.0, 1.0 / 12.0),
        joint: Joint::new(&name, JointKind::Revolute, upward(hinge_at), upward(-0.5)),
        name,
    };
    let mut bodies = Vec::new();
    for index in 0..=count {
        bodies.push(rod(format!("crank{index}"), None, index as f64));
        if index < count {
            bodies.push(rod(format!("coupler{index}"), Some(bodies.len() - 1), 0.5));
        }
    }
    let mut mechanism = Mechanism::new("four_bars", GRAVITY, bodies)?;
    for index in 0..count {
        let tip = |body| Attachment { body: Some(body), frame: upward(0.5) };
        let (a, b) = (tip(2 * index + 1), tip(2 * index + 2));
        mechanism.loops.push(LoopJoint { name: format!("closure{index}"), kind: LoopKind::Revolute, a, b });
    }
    let mut state = State::zero(&mechanism);
    for body in &mechanism.bodies {
        let sign = if body.parent.is_none() { 1.0 } else { -1.0 };
        state.position[body.joint.position_index] = sign * std::f64::consts::FRAC_PI_2;
        state.velocity[body.joint.velocity_index] = -sign;
    }
    Ok((mechanism, state))
}

/// Bricard's mechanism: five rods and six hinges, one of whose equations is redundant everywhere. Benchmark A04 of the IFToMM library.
fn bricard() -> Result<(Mechanism, State), MechanismError> {
    let points =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, -1.0, 0.0], [1.0, -1.0, 1.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]];
    let points = points.map(Vector3::from);
    let axes = [Vector3::y(), Vector3::z(), Vector3::x(), Vector3::y(), Vector3::z(), Vector3::x()];
    let center = |rod: usize| (points[rod] + points[rod + 1]) / 2.0;
    let bodies = (0..5)
        .map(|rod| {
            let along = (points[rod + 1] - points[rod]).abs();
            let parent = rod.checked_sub(1);
            let origin = parent.map_or(Vector3::zeros(), center);
            let (on_parent, on_child) =
                (frame(points[rod] - origin, axes[rod]), frame(points[rod] - center(rod), axes[rod]));
            Body {
                name: format!("rod{rod}"),
                parent,
                mass: 1.0,
                inertia: Vector3::repeat(1.01 / 12.0) - along * (1.01 / 12.0 - 0.01 / 6.0),
                joint: Joint::new(&format!("hinge{rod}"), JointKind::Revolute, on_parent, on_child),
            }
        })
        .collect();
    let mut mechanism = Mechanism::new("bricard", Vector3::new(0.0, -9.81, 0.0), bodies)?;
    mechanism.loops.push(LoopJoint {
        name: "closure".to_string(),
        kind: LoopKind::Revolute,
        a: Attachment { body: Some(4), frame: frame(points[5] - center(4), axes[5]) },
        b: Attachment { body: None, frame: frame(points[5], axes[5]) },
    });
    let state = State::zero(&mechanism);
    Ok((mechanism, state))
}

/// Sets the ball joint of the last body to a pose and spin in world axes. Its parent is the world, and its frames have the axes of world and body.
fn set_ball(state: &mut State, quaternion: [f64; 4], spin: Vector3<f64>) {
    state.position.copy_from_slice(&quaternion);
    state.velocity.copy_from_slice(spin.as_slice());
}

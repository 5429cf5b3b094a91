//! Free bodies with shapes, over a floor or not: the scenes of the tests of contact.

use crate::mechanisms::GRAVITY;
use catena::mechanism::description::contact::{Collider, ContactPair, Shape};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::state::State;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};

/// Gravity along −z [m/s²].
pub const DOWN: Vector3<f64> = Vector3::new(0.0, 0.0, -GRAVITY);

/// The principal moments of inertia of a solid body with a shape (kg m²); of a capsule those of a cylinder as long as its core.
pub fn solid(mass: f64, shape: &Shape) -> Vector3<f64> {
    match *shape {
        Shape::Sphere { radius } => Vector3::repeat(0.4 * mass * radius * radius),
        Shape::Box { half } => {
            let square = half.component_mul(&half);
            Vector3::new(square.y + square.z, square.z + square.x, square.x + square.y) * (mass / 3.0)
        }
        Shape::Capsule { radius, half } | Shape::Cylinder { radius, half } => {
            let about = 0.25 * radius * radius + half * half / 3.0;
            Vector3::new(about, about, 0.5 * radius * radius) * mass
        }
        _ => Vector3::repeat(mass),
    }
}

/// A box with these half sizes (m).
pub fn cuboid(x: f64, y: f64, z: f64) -> Shape {
    Shape::Box { half: Vector3::new(x, y, z) }
}

/// Free solid bodies with one shape each; no pair of them touches yet.
pub fn loose(gravity: Vector3<f64>, bodies: &[(f64, Shape)]) -> Mechanism {
    let body = |(number, (mass, shape)): (usize, &(f64, Shape))| {
        let name = format!("body{number}");
        let joint = Joint::new(&name, JointKind::Floating, Pose::identity(), Pose::identity());
        Body { name, parent: None, mass: *mass, inertia: solid(*mass, shape), joint }
    };
    let mut mechanism =
        Mechanism::new("loose", gravity, bodies.iter().enumerate().map(body).collect()).expect("free bodies");
    for (number, (_, shape)) in bodies.iter().enumerate() {
        let name = format!("body{number}");
        let (body, pose, shape) = (Some(number), Pose::identity(), shape.clone());
        mechanism.nonsmooth.colliders.push(Collider::still(name, body, pose, shape));
    }
    mechanism
}

/// Adds a shape of the world; returns its number.
pub fn obstacle(mechanism: &mut Mechanism, shape: Shape, at: Vector3<f64>) -> usize {
    let pose = Pose::translation(at.x, at.y, at.z);
    mechanism.nonsmooth.colliders.push(Collider::still("obstacle", None, pose, shape));
    mechanism.nonsmooth.colliders.len() - 1
}

/// Lets two colliders touch.
pub fn meet(mechanism: &mut Mechanism, a: usize, b: usize, friction: f64, restitution: f64) {
    let number = mechanism.nonsmooth.pairs.len();
    mechanism.nonsmooth.pairs.push(ContactPair::without_moments(number, [a, b], friction, restitution));
}

/// Adds a floor at z = 0, and lets everything touch everything.
pub fn on_floor(mechanism: &mut Mechanism, friction: f64, restitution: f64) {
    let count = mechanism.nonsmooth.colliders.len();
    let floor = obstacle(mechanism, Shape::HalfSpace, Vector3::zeros());
    for first in 0..count {
        meet(mechanism, floor, first, friction, restitution);
        (first + 1..count).for_each(|second| meet(mechanism, first, second, friction, restitution));
    }
}

/// Turns the floor that has been added last to a slope with this normal.
pub fn slope(mechanism: &mut Mechanism, normal: Vector3<f64>) {
    let turned = Rotation3::rotation_between(&Vector3::z(), &normal).expect("less than half a turn");
    let floor = mechanism.nonsmooth.colliders.last_mut().expect("a floor");
    floor.pose = Pose::from_parts(Vector3::zeros().into(), turned);
}

/// Puts a free body at a place, turned by a rotation vector (rad), with velocities of its centre of mass and its spin (in its own frame).
pub fn put(mechanism: &Mechanism, state: &mut State, body: usize, [at, turned, velocity, spin]: [Vector3<f64>; 4]) {
    let joint = &mechanism.bodies[body].joint;
    let turned = UnitQuaternion::from_scaled_axis(turned);
    let position = &mut state.position[joint.position_range()];
    position[..3].copy_from_slice(at.as_slice());
    position[3..].copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
    let rates = &mut state.velocity[joint.velocity_range()];
    rates[..3].copy_from_slice(velocity.as_slice());
    rates[3..].copy_from_slice(spin.as_slice());
}

/// Free bodies at rest at these places.
pub fn resting(mechanism: &Mechanism, places: &[Vector3<f64>]) -> State {
    let mut state = State::zero(mechanism);
    let none = Vector3::zeros();
    for (body, &at) in places.iter().enumerate() {
        put(mechanism, &mut state, body, [at, none, none, none]);
    }
    state
}

//! Mechanisms that move in a plane.

use crate::common::Numbers;
use crate::models::{self, Model};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::state::State;
use nalgebra::{Rotation3, Translation3, Vector3};

/// A random rotation.
pub fn turn(numbers: &mut Numbers) -> Rotation3<f64> {
    Rotation3::new(Vector3::from_fn(|_, _| numbers.next(-2.0, 2.0)))
}

pub fn place(numbers: &mut Numbers, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| numbers.next(-size, size))
}

/// A branching tree with hinges, slides and planar joints in the plane across `normal`, its bodies with inertia about axes that are
/// aligned with nothing, their centres of mass and anchors at all heights, in a generic state.
pub fn random_tree(seed: u64, count: usize, normal: Vector3<f64>) -> Model {
    let mut numbers = Numbers::new(seed);
    let upright = Rotation3::rotation_between(&Vector3::z(), &normal).expect("the normal is not −z");
    let mut bodies: Vec<Body> = Vec::new();
    let mut branch: Vec<usize> = Vec::new();
    // Each body's axes at zero displacement, so that joints can be laid across the plane.
    let mut axes: Vec<Rotation3<f64>> = Vec::new();
    for index in 0..count {
        branch.truncate((numbers.next(0.3, 1.0) * (branch.len() + 1) as f64) as usize);
        let parent = branch.last().copied();
        let spin = Rotation3::from_axis_angle(&Vector3::z_axis(), numbers.next(-3.0, 3.0));
        let over =
            Rotation3::from_axis_angle(&Vector3::x_axis(), if index % 3 == 1 { std::f64::consts::PI } else { 0.0 });
        let lying = Rotation3::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
        let (kind, frame) = match index % 7 {
            3 => (JointKind::Prismatic, upright * spin * lying),
            5 => (JointKind::Planar, upright * spin * over),
            _ => (JointKind::Revolute, upright * spin * over),
        };
        let own = turn(&mut numbers);
        let under = parent.map_or(Rotation3::identity(), |parent| axes[parent]);
        let on_parent = Pose::from_parts(Translation3::from(place(&mut numbers, 0.6)), under.inverse() * frame);
        let on_child = Pose::from_parts(Translation3::from(place(&mut numbers, 0.4)), own.inverse() * frame);
        let mass = numbers.next(0.5, 2.0);
        let inertia = models::box_inertia(mass, Vector3::new(0.3, 0.5, 0.9));
        let joint = Joint::new(&format!("joint{index}"), kind, on_parent, on_child);
        bodies.push(models::body(&format!("body{index}"), parent, mass, inertia, joint));
        axes.push(own);
        branch.push(index);
    }
    let mechanism = Mechanism::new("random tree", Vector3::new(1.0, -2.0, -9.0), bodies).expect("depth first");
    let mut state = State::zero(&mechanism);
    state.position.iter_mut().for_each(|entry| *entry = numbers.next(-1.0, 1.0));
    state.velocity.iter_mut().for_each(|entry| *entry = numbers.next(-1.0, 1.0));
    Model { mechanism, state }
}

//! What the comparator in joint coordinates claims: right accelerations, right reactions, right orders. That it moves as published
//! is tested with the scheme, in `published` and `reference_answers`.

mod dynamics;
mod integrators;

use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use nalgebra::{Rotation3, Translation3, Vector3};

const GRAVITY: f64 = 9.81;

fn body(index: usize, parent: Option<usize>, mass: f64, inertia: [f64; 3], joint: (JointKind, Pose, Pose)) -> Body {
    let (kind, on_parent, on_child) = joint;
    Body {
        name: format!("body{index}"),
        parent,
        mass,
        inertia: inertia.into(),
        joint: Joint::new(&format!("joint{index}"), kind, on_parent, on_child),
    }
}

/// Equal links that hang along −z at zero displacement, each turning about `axis(index)`.
fn chain(count: usize, mass: f64, length: f64, inertia: [f64; 3], axis: impl Fn(usize) -> [f64; 3]) -> Mechanism {
    let bodies = (0..count).map(|index| {
        let turn = Rotation3::rotation_between(&Vector3::z(), &Vector3::from(axis(index))).expect("not antiparallel");
        let frame = |z: f64| Pose::from_parts(Translation3::new(0.0, 0.0, z), turn);
        let on_parent = frame(if index == 0 { 0.0 } else { -0.5 * length });
        body(index, index.checked_sub(1), mass, inertia, (JointKind::Revolute, on_parent, frame(0.5 * length)))
    });
    Mechanism::new("chain", Vector3::new(0.0, 0.0, -GRAVITY), bodies.collect()).expect("depth first")
}

//! Mechanisms with loops, built by hand.

// Every program of tests compiles its own copy of this module and uses some of it.
#![allow(dead_code)]

use catena::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::state::State;
use nalgebra::{Rotation3, Translation3, Vector3};

/// Turns z into −y, so that a positive angle lifts x towards z.
fn upward() -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2)
}

fn frame(x: f64) -> Pose {
    Pose::from_parts(Translation3::new(x, 0.0, 0.0), upward())
}

/// A rod of 1 kg and 1 m along x, on a hinge at its end.
fn rod(name: &str, parent: Option<usize>, hinge_at: f64) -> Body {
    Body {
        name: name.into(),
        parent,
        mass: 1.0,
        inertia: Vector3::new(0.0, 1.0 / 12.0, 1.0 / 12.0),
        joint: Joint::new(name, JointKind::Revolute, frame(hinge_at), frame(-0.5)),
    }
}

/// Benchmark A02 of the IFToMM library (lim.ii.udc.es/IFToMM), N four-bars in a row, closed with revolute joints (5 equations each, 3 of them
/// redundant) or, with 3 `rows`, with spherical ones (1 redundant).
pub fn four_bars(count: usize, rows: usize) -> (Mechanism, State) {
    let mut bodies = Vec::new();
    for index in 0..=count {
        bodies.push(rod(&format!("crank{index}"), None, index as f64));
        if index < count {
            bodies.push(rod(&format!("coupler{index}"), Some(bodies.len() - 1), 0.5));
        }
    }
    let mut mechanism = Mechanism::new("four_bars", Vector3::new(0.0, 0.0, -9.81), bodies).unwrap();
    for index in 0..count {
        let tip = |body| Attachment { body: Some(body), frame: frame(0.5) };
        let kind = if rows == 5 { LoopKind::Revolute } else { LoopKind::Spherical };
        let (a, b) = (tip(2 * index + 1), tip(2 * index + 2));
        mechanism.loops.push(LoopJoint { name: format!("closure{index}"), kind, a, b });
    }
    let mut state = State::zero(&mechanism);
    for index in 0..=count {
        (state.position[2 * index], state.velocity[2 * index]) = (std::f64::consts::FRAC_PI_2, -1.0);
        if index < count {
            (state.position[2 * index + 1], state.velocity[2 * index + 1]) = (-std::f64::consts::FRAC_PI_2, 1.0);
        }
    }
    (mechanism, state)
}

/// Three rods of 1 m in a row, whose end is to be hinged to the world at `foot` along x.
pub fn arch(foot: f64) -> Mechanism {
    let bodies = vec![rod("first", None, 0.0), rod("second", Some(0), 0.5), rod("third", Some(1), 0.5)];
    let mut mechanism = Mechanism::new("arch", Vector3::new(0.0, 0.0, -9.81), bodies).unwrap();
    let (a, b) = (Attachment { body: Some(2), frame: frame(0.5) }, Attachment { body: None, frame: frame(foot) });
    mechanism.loops.push(LoopJoint { name: "foot".into(), kind: LoopKind::Revolute, a, b });
    mechanism
}

/// Benchmark A04 of the IFToMM library (lim.ii.udc.es/IFToMM), Bricard's mechanism: five rods, six hinges, one redundant equation everywhere.
pub fn bricard() -> (Mechanism, State) {
    let points =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, -1.0, 0.0], [1.0, -1.0, 1.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]];
    let points = points.map(Vector3::from);
    let axes = [Vector3::y(), Vector3::z(), Vector3::x(), Vector3::y(), Vector3::z(), Vector3::x()];
    let at = |place: Vector3<f64>, axis: Vector3<f64>| {
        let turn = Rotation3::rotation_between(&Vector3::z(), &axis).unwrap();
        Pose::from_parts(Translation3::from(place), turn)
    };
    let center = |rod: usize| (points[rod] + points[rod + 1]) / 2.0;
    let mut bodies = Vec::new();
    for rod in 0..5 {
        let along = (points[rod + 1] - points[rod]).abs();
        let inertia = Vector3::repeat(1.01 / 12.0) - along * (1.01 / 12.0 - 0.01 / 6.0);
        let parent = rod.checked_sub(1);
        let origin = parent.map_or(Vector3::zeros(), center);
        let joint = Joint::new(
            &format!("hinge{rod}"),
            JointKind::Revolute,
            at(points[rod] - origin, axes[rod]),
            at(points[rod] - center(rod), axes[rod]),
        );
        bodies.push(Body { name: format!("rod{rod}"), parent, mass: 1.0, inertia, joint });
    }
    let mut mechanism = Mechanism::new("bricard", Vector3::new(0.0, -9.81, 0.0), bodies).unwrap();
    mechanism.loops.push(LoopJoint {
        name: "closure".into(),
        kind: LoopKind::Revolute,
        a: Attachment { body: Some(4), frame: at(points[5] - center(4), axes[5]) },
        b: Attachment { body: None, frame: at(points[5], axes[5]) },
    });
    let state = State::zero(&mechanism);
    (mechanism, state)
}

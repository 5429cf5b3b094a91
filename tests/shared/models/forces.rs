//! Forces on any mechanism, each kind alone or all together.

use super::Model;
use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::forces::{Forces, JointDamper, JointLoad, JointSpring, PointSpring, Wrench};
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::scalar_coordinate;
use nalgebra::Vector3;

/// Dampers in every freedom, each with its own coefficient.
pub fn joint_dampers(mechanism: &Mechanism) -> Forces {
    let damper = |freedom: usize| JointDamper { freedom, coefficient: 0.06 + 0.02 * (freedom % 4) as f64 };
    Forces { joint_dampers: (0..mechanism.velocity_count).map(damper).collect(), ..Forces::default() }
}

/// Springs along every scalar coordinate.
pub fn joint_springs(mechanism: &Mechanism) -> Forces {
    let coordinates = (0..mechanism.velocity_count).filter_map(|freedom| scalar_coordinate(mechanism, freedom));
    let spring = |coordinate| JointSpring { coordinate, stiffness: 4.0, rest: 0.2 };
    Forces { joint_springs: coordinates.map(spring).collect(), ..Forces::default() }
}

/// Constant efforts in every freedom.
pub fn joint_loads(mechanism: &Mechanism) -> Forces {
    let load = |freedom: usize| JointLoad { freedom, effort: 0.1 - 0.06 * (freedom % 3) as f64 };
    Forces { joint_loads: (0..mechanism.velocity_count).map(load).collect(), ..Forces::default() }
}

/// A point off the centre of a body, or of the world.
pub fn point_of(body: Option<usize>, place: [f64; 3]) -> Attachment {
    Attachment { body, frame: Pose::translation(place[0], place[1], place[2]) }
}

/// Springs with dampers from the world to the first body and from there to the last.
pub fn point_springs(mechanism: &Mechanism) -> Forces {
    let spring = |name: &str, a, b| PointSpring {
        name: name.to_string(),
        a,
        b,
        stiffness: 15.0,
        damping: 0.8,
        rest_length: 0.6,
    };
    let first = point_of(Some(0), [0.1, -0.2, 0.05]);
    let mut springs = vec![spring("outer", point_of(None, [0.9, 0.4, 1.1]), first)];
    if mechanism.bodies.len() > 1 {
        let last = point_of(Some(mechanism.bodies.len() - 1), [-0.1, 0.1, -0.2]);
        springs.push(spring("inner", last, point_of(Some(0), [0.05, 0.3, 0.1])));
    }
    Forces { point_springs: springs, ..Forces::default() }
}

/// A constant force and torque on the last body.
pub fn wrenches(mechanism: &Mechanism) -> Forces {
    let wrench = Wrench {
        body: mechanism.bodies.len() - 1,
        point: Vector3::new(0.1, 0.2, -0.1),
        force: Vector3::new(1.5, -0.7, 2.0),
        torque: Vector3::new(0.2, 0.4, -0.3),
    };
    Forces { wrenches: vec![wrench], ..Forces::default() }
}

/// Every kind of force alone, then all together; with their names.
pub fn every_force(mechanism: &Mechanism) -> Vec<(&'static str, Forces)> {
    let parts = [joint_dampers, joint_springs, joint_loads, point_springs, wrenches].map(|build| build(mechanism));
    let [dampers, springs, loads, lines, wrenches] = parts.clone();
    let all = Forces {
        joint_dampers: dampers.joint_dampers,
        joint_springs: springs.joint_springs,
        joint_loads: loads.joint_loads,
        point_springs: lines.point_springs,
        wrenches: wrenches.wrenches,
        driven: false,
        ..Forces::default()
    };
    let names = ["joint dampers", "joint springs", "joint loads", "point springs", "wrenches"];
    names.into_iter().zip(parts).chain([("all forces", all)]).collect()
}

/// The model with forces.
pub fn with_forces(mut model: Model, forces: Forces) -> Model {
    model.mechanism.forces = forces;
    model
}

//! The numbers of joints in a log, each with its quantity, its joint and its unit.

use crate::model::Model;
use crate::output::log::messages::motors::OF_GRAVITY;
use crate::output::log::reading::decode::MultiDofStates;
use crate::output::log::reading::frames::Frame;
use crate::scene::UrdfJointKind;
use std::collections::HashMap;

/// The kinds of joints by name, which the joint messages do not tell.
pub type JointKinds = HashMap<String, UrdfJointKind>;

/// The kinds of a model's joints.
pub fn joint_kinds(model: &Model) -> JointKinds {
    model.joints.iter().map(|joint| (joint.name.clone(), joint.kind)).collect()
}

/// The quantity of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    Angle,
    Length,
    /// The position of a joint whose kind is not known.
    Displacement,
    Orientation,
    AngularVelocity,
    LinearVelocity,
    /// See `Displacement`.
    Rate,
    MotorTorque,
    MotorForce,
    /// See `Displacement`.
    MotorEffort,
    EnergyError,
    Violation,
    Effort,
    Force,
    Torque,
    ContactForce,
    /// Derivatives by a parameter.
    Slope,
    RateSlope,
}

impl Quantity {
    /// Its unit; empty for numbers without.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Angle => "rad",
            Quantity::Length => "m",
            Quantity::Orientation | Quantity::EnergyError => "",
            Quantity::AngularVelocity => "rad/s",
            Quantity::LinearVelocity => "m/s",
            Quantity::Violation => "m, m/s",
            Quantity::Effort | Quantity::MotorEffort => "N m, N",
            Quantity::Force | Quantity::MotorForce | Quantity::ContactForce => "N",
            Quantity::Torque | Quantity::MotorTorque => "N m",
            Quantity::Displacement => "rad or m",
            Quantity::Rate => "rad/s or m/s",
            Quantity::Slope | Quantity::RateSlope => "per unit",
        }
    }

    pub fn title(self) -> &'static str {
        match self {
            Quantity::Angle => "Joint positions, turning",
            Quantity::Length => "Joint positions, sliding",
            Quantity::Orientation => "Joint orientations, quaternions",
            Quantity::AngularVelocity => "Joint velocities, turning",
            Quantity::LinearVelocity => "Joint velocities, sliding",
            Quantity::EnergyError => "Energy error / largest kinetic energy",
            Quantity::Violation => "Constraint violation",
            Quantity::Effort => "Efforts along the joint axes",
            Quantity::Force => "Reaction forces",
            Quantity::Torque => "Reaction torques",
            Quantity::ContactForce => "Contact forces",
            Quantity::MotorTorque => "Motor efforts, turning",
            Quantity::MotorForce => "Motor efforts, sliding",
            Quantity::MotorEffort => "Motor efforts",
            Quantity::Displacement => "Joint positions",
            Quantity::Rate => "Joint velocities",
            Quantity::Slope => "Derivatives of joint positions",
            Quantity::RateSlope => "Derivatives of joint velocities",
        }
    }

    pub fn is_logarithmic(self) -> bool {
        matches!(self, Quantity::EnergyError | Quantity::Violation)
    }
}

/// A number of a joint.
pub struct JointValue {
    /// Joint and component: `elbow.position`, `base.velocity.wx`.
    pub name: String,
    /// The joint.
    pub joint: String,
    /// The component alone, empty if there is only one.
    pub component: &'static str,
    /// Its quantity.
    pub quantity: Quantity,
    /// The number.
    pub value: f64,
}

/// Every number about joints in a frame.
pub fn joint_values(frame: &Frame, kinds: &JointKinds) -> Vec<JointValue> {
    let mut all = Vec::new();
    let mut add = |joint: &str, what: &str, component: &'static str, quantity, value| {
        let dot = if component.is_empty() { "" } else { "." };
        all.push(JointValue {
            name: format!("{joint}.{what}{dot}{component}"),
            joint: joint.to_string(),
            component,
            quantity,
            value,
        });
    };
    let quantities = |joint: &str| match kinds.get(joint) {
        Some(UrdfJointKind::Prismatic) => (Quantity::Length, Quantity::LinearVelocity, Quantity::Force),
        Some(_) => (Quantity::Angle, Quantity::AngularVelocity, Quantity::Torque),
        None => (Quantity::Displacement, Quantity::Rate, Quantity::Effort),
    };
    for (index, joint) in frame.joints.names.iter().enumerate() {
        let (position, velocity, effort) = quantities(joint);
        let numbers = [
            ("position", position, &frame.joints.positions),
            ("velocity", velocity, &frame.joints.velocities),
            ("effort", effort, &frame.joints.efforts),
        ];
        for (what, quantity, values) in numbers {
            if let Some(&value) = values.get(index) {
                add(joint, what, "", quantity, value);
            }
        }
    }
    for (joint, &effort) in frame.motors.names.iter().zip(&frame.motors.efforts) {
        let (joint, what) = match joint.strip_suffix(OF_GRAVITY) {
            Some(held) => (held, "gravity_compensation"),
            None => (joint.as_str(), "motor_effort"),
        };
        let quantity = match kinds.get(joint) {
            Some(UrdfJointKind::Prismatic) => Quantity::MotorForce,
            Some(_) => Quantity::MotorTorque,
            None => Quantity::MotorEffort,
        };
        add(joint, what, "", quantity, effort);
    }
    for (index, joint) in frame.multi_dof.names.iter().enumerate() {
        let slides = kinds.get(joint) != Some(&UrdfJointKind::Spherical);
        if let Some((at, turn)) = frame.multi_dof.transforms.get(index) {
            for (component, value) in ["x", "y", "z"].into_iter().zip(at).filter(|_| slides) {
                add(joint, "position", component, Quantity::Length, *value);
            }
            for (component, value) in ["qw", "qx", "qy", "qz"].into_iter().zip(turn) {
                add(joint, "position", component, Quantity::Orientation, *value);
            }
        }
        if let Some((linear, angular)) = frame.multi_dof.twists.get(index) {
            for (component, value) in ["vx", "vy", "vz"].into_iter().zip(linear).filter(|_| slides) {
                add(joint, "velocity", component, Quantity::LinearVelocity, *value);
            }
            for (component, value) in ["wx", "wy", "wz"].into_iter().zip(angular) {
                add(joint, "velocity", component, Quantity::AngularVelocity, *value);
            }
        }
    }
    for (joint, (force, torque)) in wrenches(&frame.reactions) {
        for (component, value) in ["x", "y", "z"].into_iter().zip(force) {
            add(joint, "reaction_force", component, Quantity::Force, *value);
        }
        for (component, value) in ["x", "y", "z"].into_iter().zip(torque) {
            add(joint, "reaction_torque", component, Quantity::Torque, *value);
        }
    }
    all
}

/// The forces of the second of two shapes on the first, over all points at which they touch (N), by pairs `a|b` in the order of the log.
pub(crate) fn contact_forces(frame: &Frame) -> Vec<(String, [f64; 3])> {
    let mut forces: Vec<(String, [f64; 3])> = Vec::new();
    for contact in &frame.contacts {
        let pair = format!("{}|{}", contact.a, contact.b);
        match forces.iter_mut().find(|(known, _)| *known == pair) {
            Some((_, sum)) => sum.iter_mut().zip(contact.force).for_each(|(sum, force)| *sum += force),
            None => forces.push((pair, contact.force)),
        }
    }
    forces
}

/// The wrenches of the reactions, by joint.
pub(crate) fn wrenches(reactions: &MultiDofStates) -> impl Iterator<Item = (&str, &([f64; 3], [f64; 3]))> {
    reactions.names.iter().map(String::as_str).zip(&reactions.wrenches)
}

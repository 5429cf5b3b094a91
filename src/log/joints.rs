//! The joints' part of a sample: the whole state, in the coordinates of the URDF ([`Model::joint_user_coordinates`]).
//!
//! Joints of one number go into `sensor_msgs/msg/JointState`, the others into `sensor_msgs/msg/MultiDOFJointState`,
//! both in the joint's frame on the parent:
//!
//! | joint     | transform                                        | twist                        |
//! |-----------|--------------------------------------------------|------------------------------|
//! | floating  | the child link's frame                           | of its origin                |
//! | spherical | the rotation                                     | the angular velocity         |
//! | planar    | in a frame whose z is the axis: x, y, angle about z | their rates               |
//!
//! The effort of a joint of one number is what the parent exerts on the child along the axis: zero where nothing drives
//! the joint, up to rounding. `/reactions` has all of what joints carry, at the origin of the joint's frame on the child
//! in the axes of the world: what `catena simulate --json` calls `reaction_force` and `reaction_torque`.

use super::batch::Batch;
use super::file::{LogChannels, LogError};
use super::ros::{self, JointHeader, ros_channel};
use crate::model::Model;
use crate::model::joint::JointKind;
use crate::reactions::Reactions;
use crate::reduced::Reaction;
use crate::simulation::Sample;
use crate::state::quaternion_exponential;
use nalgebra::Vector3;

/// Writes the joint messages of samples.
pub(super) struct JointMessages<'m> {
    model: &'m Model,
    channel: u16,
    header: JointHeader,
    /// The bodies that the joints of one number move.
    bodies: Vec<usize>,
    others: Option<OtherJoints>,
    loads: Loads,
    reactions: Reactions<'m>,
}

/// What the joints carry.
struct Loads {
    channel: u16,
    header: JointHeader,
    /// The bodies of all joints that move, save a floating base, which nothing holds.
    bodies: Vec<usize>,
}

/// The joints of several numbers.
struct OtherJoints {
    channel: u16,
    header: JointHeader,
    /// Their numbers among the joints of the model.
    joints: Vec<usize>,
}

impl<'m> JointMessages<'m> {
    /// Adds the channels that the joints of the model need; reactions are in the frame `world`.
    pub(super) fn new(file: &mut dyn LogChannels, model: &'m Model, world: &str) -> Result<Self, LogError> {
        let name = |&joint: &usize| model.joints[joint].name.as_str();
        let joint_of = |joint: usize| Some(&model.mechanism.bodies[model.joints[joint].body?].joint);
        let moving = (0..model.joints.len()).filter(|&joint| joint_of(joint).is_some());
        let (scalar, other): (Vec<usize>, Vec<usize>) =
            moving.partition(|&joint| joint_of(joint).is_some_and(|joint| joint.kind.position_count() == 1));
        let body_of = |&joint: &usize| model.joints[joint].body;
        let holds = |joint: &usize| joint_of(*joint).is_some_and(|joint| joint.kind != JointKind::Floating);
        let held: Vec<usize> = (0..model.joints.len()).filter(holds).collect();
        let loops = model.mechanism.loops.iter().map(|joint| joint.name.as_str());
        let carriers: Vec<&str> = held.iter().map(name).chain(loops).collect();
        let loads = Loads {
            channel: ros_channel(file, "/reactions", ros::MULTI_DOF_JOINT_STATE)?,
            header: JointHeader::new(world, carriers.into_iter()),
            bodies: held.iter().filter_map(body_of).collect(),
        };
        Ok(JointMessages {
            model,
            channel: ros_channel(file, "/joint_states", ros::JOINT_STATE)?,
            header: JointHeader::new("", scalar.iter().map(name)),
            bodies: scalar.iter().filter_map(body_of).collect(),
            loads,
            reactions: Reactions::new(&model.mechanism),
            others: if other.is_empty() {
                None
            } else {
                let channel = ros_channel(file, "/multi_dof_joint_states", ros::MULTI_DOF_JOINT_STATE)?;
                Some(OtherJoints { channel, header: JointHeader::new("", other.iter().map(name)), joints: other })
            },
        })
    }

    /// Adds the messages of one sample.
    pub(super) fn write(&mut self, sample: &Sample, stamp: u64, buffer: &mut Vec<u8>, messages: &mut Batch) {
        let bodies = &self.model.mechanism.bodies;
        let (reactions, loops) = self.reactions.of_placed(sample.position, sample.velocity, sample.bodies);
        let positions = self.bodies.iter().map(|&body| sample.position[bodies[body].joint.position_index]);
        let velocities = self.bodies.iter().map(|&body| sample.velocity[bodies[body].joint.velocity_index]);
        let efforts = self.bodies.iter().map(|&body| {
            let joint = &bodies[body].joint;
            let axis = sample.bodies[body].rotation * joint.on_child.rotation.matrix().column(2);
            let Reaction { force, torque, .. } = &reactions[body];
            if joint.kind == JointKind::Prismatic { force.dot(&axis) } else { torque.dot(&axis) }
        });
        self.header.encode_joint_state(stamp, positions, velocities, efforts, buffer);
        messages.push(self.channel, stamp, buffer);
        let wrench =
            |force: &Vector3<f64>, torque: &Vector3<f64>| [force.x, force.y, force.z, torque.x, torque.y, torque.z];
        let joints = self.loads.bodies.iter().map(|&body| wrench(&reactions[body].force, &reactions[body].torque));
        let carried = joints.chain(loops.iter().map(|one| wrench(&one.force, &one.torque)));
        self.loads.header.encode_wrenches(stamp, self.loads.bodies.len() + loops.len(), carried, buffer);
        messages.push(self.loads.channel, stamp, buffer);
        if let Some(others) = &self.others {
            let joints = others.joints.iter().map(|&joint| {
                let coordinates = self.model.joint_coordinates(joint, sample.position, sample.velocity);
                transform_and_twist(coordinates.position(), coordinates.velocity())
            });
            others.header.encode_multi_dof(stamp, joints, buffer);
            messages.push(others.channel, stamp, buffer);
        }
    }
}

/// The transform (x, y, z, quaternion w, x, y, z) and the twist (linear, angular) of a joint's reported coordinates.
fn transform_and_twist(position: &[f64], velocity: &[f64]) -> ([f64; 7], [f64; 6]) {
    match (position, velocity) {
        (&[x, y, z, qw, qx, qy, qz], &[vx, vy, vz, wx, wy, wz]) => {
            ([x, y, z, qw, qx, qy, qz], [vx, vy, vz, wx, wy, wz])
        }
        (&[qw, qx, qy, qz], &[wx, wy, wz]) => ([0.0, 0.0, 0.0, qw, qx, qy, qz], [0.0, 0.0, 0.0, wx, wy, wz]),
        (&[x, y, angle], &[vx, vy, rate]) => {
            let [qw, qx, qy, qz] = quaternion_exponential(&[0.0, 0.0, angle]);
            ([x, y, 0.0, qw, qx, qy, qz], [vx, vy, 0.0, 0.0, 0.0, rate])
        }
        // No joint has other counts.
        _ => ([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.0; 6]),
    }
}

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

use super::batch::Batch;
use super::file::{LogError, LogFile};
use super::ros::{self, JointHeader, ros_channel};
use crate::model::Model;
use crate::simulation::Sample;
use crate::state::quaternion_exponential;

/// Writes the joint messages of samples.
pub(super) struct JointMessages<'m> {
    model: &'m Model,
    channel: u16,
    header: JointHeader,
    /// Places of the joints of one number in the position and in the velocity vector.
    places: Vec<(usize, usize)>,
    others: Option<OtherJoints>,
}

/// The joints of several numbers.
struct OtherJoints {
    channel: u16,
    header: JointHeader,
    /// Their numbers among the joints of the model.
    joints: Vec<usize>,
}

impl<'m> JointMessages<'m> {
    /// Adds the channels that the joints of the model need.
    pub(super) fn new(file: &mut LogFile, model: &'m Model) -> Result<Self, LogError> {
        let name = |&joint: &usize| model.joints[joint].name.as_str();
        let joint_of = |joint: usize| Some(&model.mechanism.bodies[model.joints[joint].body?].joint);
        let moving = (0..model.joints.len()).filter(|&joint| joint_of(joint).is_some());
        let (scalar, other): (Vec<usize>, Vec<usize>) =
            moving.partition(|&joint| joint_of(joint).is_some_and(|joint| joint.kind.position_count() == 1));
        let places = scalar.iter().filter_map(|&joint| joint_of(joint));
        Ok(JointMessages {
            model,
            channel: ros_channel(file, "/joint_states", ros::JOINT_STATE)?,
            header: JointHeader::new(scalar.iter().map(name)),
            places: places.map(|joint| (joint.position_index, joint.velocity_index)).collect(),
            others: if other.is_empty() {
                None
            } else {
                let channel = ros_channel(file, "/multi_dof_joint_states", ros::MULTI_DOF_JOINT_STATE)?;
                Some(OtherJoints { channel, header: JointHeader::new(other.iter().map(name)), joints: other })
            },
        })
    }

    /// Adds the messages of one sample.
    pub(super) fn write(&self, sample: &Sample, stamp: u64, buffer: &mut Vec<u8>, messages: &mut Batch) {
        let positions = self.places.iter().map(|&(position, _)| sample.position[position]);
        let velocities = self.places.iter().map(|&(_, velocity)| sample.velocity[velocity]);
        self.header.encode_joint_state(stamp, positions, velocities, buffer);
        messages.push(self.channel, stamp, buffer);
        if let Some(others) = &self.others {
            let joints = others.joints.iter().map(|&joint| {
                let (position, velocity) = self.model.joint_user_coordinates(joint, sample.position, sample.velocity);
                transform_and_twist(&position, &velocity)
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

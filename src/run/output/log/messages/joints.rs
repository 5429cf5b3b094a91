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
//! The effort of a joint of one number is the effort that the parent exerts on the child along the axis: zero, up to rounding, if the joint is not
//! driven. `/reactions` has the whole wrench of each joint, at the origin of the joint's frame on the child in the axes of the world: `catena
//! simulate --json` calls it `reaction_force` and `reaction_torque`.

use crate::lobatto::instants::snapshot::{Row, Snapshots};
use crate::mechanism::description::joint::JointKind;
use crate::mechanism::motion::state::quaternion_exponential;
use crate::model::Model;
use crate::output::log::encoding::definitions::{Definition, JOINT_STATE, MULTI_DOF_JOINT_STATE};
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::template::Template;
use crate::output::log::messages::topics::Topics;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;

/// Writes the joint messages of samples.
pub(crate) struct JointMessages {
    /// The mechanism and its joints alone.
    model: Model,
    /// `None` if the topic is not wanted.
    scalars: Option<ScalarJoints>,
    others: Option<OtherJoints>,
    loads: Option<Loads>,
}

/// The joints of one number.
struct ScalarJoints {
    channel: u16,
    template: Template,
    /// The bodies that they move.
    bodies: Vec<usize>,
}

/// The wrenches of the joints.
struct Loads {
    channel: u16,
    template: Template,
    /// The bodies of all joints that move, save a floating base, which no joint holds.
    bodies: Vec<usize>,
}

/// The joints of several numbers.
struct OtherJoints {
    channel: u16,
    template: Template,
    /// Their numbers among the joints of the model.
    joints: Vec<usize>,
}

impl JointMessages {
    /// Adds the channels that the joints of the model need and that are wanted; reactions are in the frame `world`.
    pub(crate) fn new(
        file: &mut dyn MessageSink,
        model: &Model,
        world: &str,
        wanted: &Topics,
    ) -> Result<Self, LogError> {
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
        let mut channel = |topic: &str, definition: &Definition| {
            wanted.has(topic).then(|| file.channel(topic, definition, Durability::Volatile)).transpose()
        };
        let loads = channel("/reactions", &MULTI_DOF_JOINT_STATE)?.map(|channel| Loads {
            channel,
            template: Template::wrenches(world, carriers.into_iter()),
            bodies: held.iter().filter_map(body_of).collect(),
        });
        let scalars = channel("/joint_states", &JOINT_STATE)?.map(|channel| ScalarJoints {
            channel,
            template: Template::joint_state("", scalar.iter().map(name)),
            bodies: scalar.iter().filter_map(body_of).collect(),
        });
        let others = match other.is_empty() {
            true => None,
            false => channel("/multi_dof_joint_states", &MULTI_DOF_JOINT_STATE)?,
        };
        Ok(JointMessages {
            model: Model {
                mechanism: model.mechanism.clone(),
                joints: model.joints.clone(),
                links: Vec::new(),
                reductions: Vec::new(),
                warnings: Vec::new(),
                robots: Vec::new(),
                scene: None,
                tables: Vec::new(),
                damping: 0..0,
                at_start: Vec::new(),
                contact: Default::default(),
            },
            scalars,
            loads,
            others: others.map(|channel| {
                let template = Template::multi_dof("", other.iter().map(name));
                OtherJoints { channel, template, joints: other.clone() }
            }),
        })
    }

    /// Adds the messages of a sample: its positions and velocities, and which of the snapshots it is.
    pub(crate) fn write(
        &self,
        (position, velocity): (&[f64], &[f64]),
        (snapshots, instant): (&Snapshots, usize),
        stamp: u64,
        sink: &mut dyn MessageSink,
    ) -> Result<(), LogError> {
        if let Some(ScalarJoints { channel, template, bodies: moved }) = &self.scalars {
            let bodies = &self.model.mechanism.bodies;
            let message = sink.message(*channel, stamp, template.encoded())?;
            template.fill_stamp(message, stamp);
            template.fill(message, 0, moved.iter().map(|&body| position[bodies[body].joint.position_index]));
            template.fill(message, 1, moved.iter().map(|&body| velocity[bodies[body].joint.velocity_index]));
            template.fill(message, 2, moved.iter().map(|&body| snapshots.efforts[body][instant]));
        }
        if let Some(Loads { channel, template, bodies }) = &self.loads {
            let message = sink.message(*channel, stamp, template.encoded())?;
            template.fill_stamp(message, stamp);
            let carried = bodies.iter().map(|&body| &snapshots.wrenches[body]).chain(&snapshots.loops);
            let wrench = |[fx, fy, fz, tx, ty, tz]: &[Row; 6]| {
                [fx[instant], fy[instant], fz[instant], tx[instant], ty[instant], tz[instant]]
            };
            template.fill_structures(message, 0, carried.map(wrench));
        }
        let Some(OtherJoints { channel, template, joints }) = &self.others else { return Ok(()) };
        let message = sink.message(*channel, stamp, template.encoded())?;
        template.fill_stamp(message, stamp);
        let coordinates = joints.iter().map(|&joint| self.model.joint_coordinates(joint, position, velocity));
        let numbers = coordinates.map(|joint| transform_and_twist(joint.position(), joint.velocity()));
        let transforms = |([x, y, z, qw, qx, qy, qz], _): ([f64; 7], _)| [x, y, z, qx, qy, qz, qw];
        template.fill_structures(message, 0, numbers.clone().map(transforms));
        template.fill_structures(message, 1, numbers.map(|(_, twist)| twist));
        Ok(())
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

//! The ROS 2 messages of the log: their definitions, as schemas carry them, and their encoding.
//!
//! A `ros2msg` schema is the definition of the message followed by those of the messages it uses, each after a line
//! of 80 equals signs and a line that names it.

use crate::output::log::cdr;
use crate::output::log::cdr::CdrWriter;
use crate::output::log::error::LogError;
use crate::output::log::file::MessageSink;

/// Adds a channel for messages of one of the definitions below.
pub(crate) fn ros_channel(
    file: &mut dyn MessageSink,
    topic: &str,
    (name, definition): (&str, &str),
) -> Result<u16, LogError> {
    file.channel(topic, (name, "ros2msg", definition.as_bytes()), "cdr")
}

/// `std_msgs/msg/String`.
pub(crate) const STRING: (&str, &str) = ("std_msgs/msg/String", "string data\n");

/// `sensor_msgs/msg/JointState`.
pub(crate) const JOINT_STATE: (&str, &str) = (
    "sensor_msgs/msg/JointState",
    "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
",
);

/// `sensor_msgs/msg/MultiDOFJointState`.
pub(crate) const MULTI_DOF_JOINT_STATE: (&str, &str) = (
    "sensor_msgs/msg/MultiDOFJointState",
    "\
std_msgs/Header header
string[] joint_names
geometry_msgs/Transform[] transforms
geometry_msgs/Twist[] twist
geometry_msgs/Wrench[] wrench
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
================================================================================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
================================================================================
MSG: geometry_msgs/Wrench
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
",
);

/// `std_msgs/msg/Float64MultiArray`.
pub(crate) const FLOAT64_MULTI_ARRAY: (&str, &str) = (
    "std_msgs/msg/Float64MultiArray",
    "\
std_msgs/MultiArrayLayout layout
float64[] data
================================================================================
MSG: std_msgs/MultiArrayLayout
std_msgs/MultiArrayDimension[] dim
uint32 data_offset
================================================================================
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
",
);

/// An event, which no package of ROS defines: viewers decode it by this definition, which is in the log.
pub(crate) const EVENT: (&str, &str) = (
    "catena_msgs/msg/Event",
    "\
std_msgs/Header header
float64 time
string kind
string what
float64 impulse
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
",
);

/// Encodes a `std_msgs/msg/String`.
pub(crate) fn encode_string(text: &str, out: &mut Vec<u8>) {
    CdrWriter::begin(out).string(text);
}

/// A message of which all but the numbers is the same again and again.
pub(crate) struct Template {
    encoded: Vec<u8>,
    /// Where each row of numbers begins.
    rows: Vec<usize>,
}

/// Where the stamp is in messages about joints.
const STAMP: std::ops::Range<usize> = 4..12;

impl Template {
    /// A `std_msgs/msg/Float64MultiArray` of one dimension, whose label says what its row of numbers is.
    pub(crate) fn figures(label: &str, count: usize) -> Self {
        let mut encoded = Vec::new();
        let mut writer = CdrWriter::begin(&mut encoded);
        writer.unsigned(1);
        writer.string(label);
        writer.unsigned(count as u32);
        writer.unsigned(count as u32);
        writer.unsigned(0);
        let rows = vec![writer.structures::<1>(count)];
        Template { encoded, rows }
    }

    /// A `sensor_msgs/msg/JointState`: rows of positions, velocities and efforts.
    pub(crate) fn joint_state<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let count = names.len();
        Self::new(frame, names, |writer| [0; 3].map(|_| writer.structures::<1>(count)).to_vec())
    }

    /// A `sensor_msgs/msg/JointState` with efforts alone: one row of them.
    pub(crate) fn efforts<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let count = names.len();
        Self::new(frame, names, |writer| {
            writer.unsigned(0);
            writer.unsigned(0);
            vec![writer.structures::<1>(count)]
        })
    }

    /// A `sensor_msgs/msg/MultiDOFJointState` with wrenches (force, torque) alone: one row of six numbers each.
    pub(crate) fn wrenches<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let count = names.len();
        Self::new(frame, names, |writer| {
            writer.unsigned(0);
            writer.unsigned(0);
            vec![writer.structures::<6>(count)]
        })
    }

    /// A `sensor_msgs/msg/MultiDOFJointState` without wrenches: a row of seven numbers each, x, y, z and the quaternion x, y, z, w, and
    /// one of six, the linear and the angular velocity.
    pub(crate) fn multi_dof<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let count = names.len();
        Self::new(frame, names, |writer| {
            let rows = vec![writer.structures::<7>(count), writer.structures::<6>(count)];
            writer.unsigned(0);
            rows
        })
    }

    /// A header, the names, and what `rest` adds, which returns where the rows are.
    fn new<'n>(
        frame: &str,
        names: impl ExactSizeIterator<Item = &'n str>,
        rest: impl FnOnce(&mut CdrWriter) -> Vec<usize>,
    ) -> Self {
        let mut encoded = Vec::new();
        let mut writer = CdrWriter::begin(&mut encoded);
        writer.time(0);
        writer.string(frame);
        writer.unsigned(names.len() as u32);
        names.for_each(|name| writer.string(name));
        let rows = rest(&mut writer);
        Template { encoded, rows }
    }

    /// The message with zeros.
    pub(crate) fn encoded(&self) -> &[u8] {
        &self.encoded
    }

    /// Puts the time into a message.
    pub(crate) fn fill_stamp(&self, message: &mut [u8], nanoseconds: u64) {
        message[STAMP].copy_from_slice(&cdr::time(nanoseconds));
    }

    /// Puts the numbers of a row into a message.
    pub(crate) fn fill(&self, message: &mut [u8], row: usize, values: impl Iterator<Item = f64>) {
        cdr::fill(&mut message[self.rows[row]..], values);
    }

    /// Puts the numbers of a row of structures into a message.
    pub(crate) fn fill_structures<const N: usize>(
        &self,
        message: &mut [u8],
        row: usize,
        structures: impl Iterator<Item = [f64; N]>,
    ) {
        for (bytes, structure) in message[self.rows[row]..].chunks_exact_mut(8 * N).zip(structures) {
            cdr::fill(bytes, structure.into_iter());
        }
    }
}

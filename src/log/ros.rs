//! The ROS 2 messages of the log: their definitions, as schemas carry them, and their encoding.
//!
//! A `ros2msg` schema is the definition of the message followed by those of the messages it uses, each after a line
//! of 80 equals signs and a line that names it.

use super::cdr::CdrWriter;
use super::file::{LogChannels, LogError};

/// Adds a channel for messages of one of the definitions below.
pub(super) fn ros_channel(
    file: &mut dyn LogChannels,
    topic: &str,
    (name, definition): (&str, &str),
) -> Result<u16, LogError> {
    file.channel(topic, (name, "ros2msg", definition.as_bytes()), "cdr")
}

/// `std_msgs/msg/String`.
pub(super) const STRING: (&str, &str) = ("std_msgs/msg/String", "string data\n");

/// `sensor_msgs/msg/JointState`.
pub(super) const JOINT_STATE: (&str, &str) = (
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
pub(super) const MULTI_DOF_JOINT_STATE: (&str, &str) = (
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
pub(super) const FLOAT64_MULTI_ARRAY: (&str, &str) = (
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

/// Encodes a `std_msgs/msg/String`.
pub(super) fn encode_string(text: &str, out: &mut Vec<u8>) {
    CdrWriter::begin(out).string(text);
}

/// Encodes `std_msgs/msg/Float64MultiArray`s of one dimension, whose label says what the numbers are.
pub(super) fn encode_figures(label: &str, figures: &[f64], out: &mut Vec<u8>) {
    let mut writer = CdrWriter::begin(out);
    let count = figures.len() as u32;
    writer.unsigned(1);
    writer.string(label);
    writer.unsigned(count);
    writer.unsigned(count);
    writer.unsigned(0);
    writer.doubles(figures.iter().copied());
}

/// The beginning of a message about joints: a header and their names.
pub(super) struct JointHeader {
    /// The encoded beginning, with a stamp of zero.
    encoded: Vec<u8>,
}

/// Where the stamp is in the encoded message.
const STAMP: std::ops::Range<usize> = 4..12;

impl JointHeader {
    /// The beginning for joints of these names, with numbers in a frame.
    pub(super) fn new<'n>(frame: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let mut encoded = Vec::new();
        let mut writer = CdrWriter::begin(&mut encoded);
        writer.time(0);
        writer.string(frame);
        writer.unsigned(names.len() as u32);
        names.for_each(|name| writer.string(name));
        JointHeader { encoded }
    }

    fn begin<'b>(&self, nanoseconds: u64, out: &'b mut Vec<u8>) -> CdrWriter<'b> {
        CdrWriter::begin(out).time(nanoseconds);
        out.extend_from_slice(&self.encoded[STAMP.end..]);
        CdrWriter::resume(out)
    }

    /// Encodes a `sensor_msgs/msg/JointState`.
    pub(super) fn encode_joint_state(
        &self,
        nanoseconds: u64,
        positions: impl ExactSizeIterator<Item = f64>,
        velocities: impl ExactSizeIterator<Item = f64>,
        efforts: impl ExactSizeIterator<Item = f64>,
        out: &mut Vec<u8>,
    ) {
        let mut writer = self.begin(nanoseconds, out);
        writer.doubles(positions);
        writer.doubles(velocities);
        writer.doubles(efforts);
    }

    /// Encodes a `sensor_msgs/msg/MultiDOFJointState` with `count` wrenches (force, torque) alone.
    pub(super) fn encode_wrenches(
        &self,
        nanoseconds: u64,
        count: usize,
        wrenches: impl Iterator<Item = [f64; 6]>,
        out: &mut Vec<u8>,
    ) {
        let mut writer = self.begin(nanoseconds, out);
        writer.unsigned(0);
        writer.unsigned(0);
        writer.unsigned(count as u32);
        wrenches.for_each(|wrench| writer.numbers(&wrench));
    }

    /// Encodes a `sensor_msgs/msg/MultiDOFJointState`; wrenches are left empty.
    ///
    /// Transforms are x, y, z and the quaternion w, x, y, z; twists the linear and the angular velocity.
    pub(super) fn encode_multi_dof(
        &self,
        nanoseconds: u64,
        joints: impl ExactSizeIterator<Item = ([f64; 7], [f64; 6])> + Clone,
        out: &mut Vec<u8>,
    ) {
        let mut writer = self.begin(nanoseconds, out);
        writer.unsigned(joints.len() as u32);
        for ([x, y, z, qw, qx, qy, qz], _) in joints.clone() {
            writer.numbers(&[x, y, z, qx, qy, qz, qw]);
        }
        writer.unsigned(joints.len() as u32);
        joints.for_each(|(_, twist)| writer.numbers(&twist));
        writer.unsigned(0);
    }
}

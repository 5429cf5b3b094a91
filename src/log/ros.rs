//! The ROS 2 messages of the log: their definitions, as schemas carry them, and their encoding.
//!
//! A `ros2msg` schema is the definition of the message followed by those of the messages it uses, each after a line
//! of 80 equals signs and a line that names it.

use super::cdr::CdrWriter;

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

/// Encodes `sensor_msgs/msg/JointState`s of a fixed list of joints; all but the numbers is encoded once.
pub(super) struct JointStateEncoder {
    /// The message up to and with the names, with a stamp of zero.
    beginning: Vec<u8>,
}

/// Where the stamp is in the encoded message.
const STAMP: std::ops::Range<usize> = 4..12;

impl JointStateEncoder {
    /// An encoder for joints of these names.
    pub(super) fn new<'n>(names: impl ExactSizeIterator<Item = &'n str>) -> Self {
        let mut beginning = Vec::new();
        let mut writer = CdrWriter::begin(&mut beginning);
        writer.time(0);
        writer.string("");
        writer.unsigned(names.len() as u32);
        names.for_each(|name| writer.string(name));
        JointStateEncoder { beginning }
    }

    /// Encodes the message; efforts are left empty.
    pub(super) fn encode(
        &self,
        nanoseconds: u64,
        positions: impl ExactSizeIterator<Item = f64>,
        velocities: impl ExactSizeIterator<Item = f64>,
        out: &mut Vec<u8>,
    ) {
        CdrWriter::begin(out).time(nanoseconds);
        out.extend_from_slice(&self.beginning[STAMP.end..]);
        let mut writer = CdrWriter::resume(out);
        writer.doubles(positions);
        writer.doubles(velocities);
        writer.doubles(std::iter::empty());
    }
}

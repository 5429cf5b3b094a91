//! Decodes the messages that [`crate::output::log::Recorder`] writes.
//!
//! A damaged message is an error, never a panic or a huge allocation.

use crate::output::log::encoding::cdr_reader::CdrReader;
use crate::output::log::encoding::line::level;
use crate::output::log::encoding::severity::Severity;
use serde::Serialize;

/// A link's frame in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkPose {
    /// Name of the link.
    pub link: String,
    /// Origin (m).
    pub position: [f64; 3],
    /// Orientation, as w, x, y, z.
    pub orientation: [f64; 4],
}

/// A line of text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// Whether it is a warning or an error.
    pub is_problem: bool,
    /// The text.
    pub text: String,
}

/// An event.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedEvent {
    /// When (s).
    pub time: f64,
    /// The kind of the event.
    pub kind: String,
    /// The joint to which it happened.
    pub what: String,
    /// The impulse of an impact [N m s or N s].
    pub impulse: Option<f64>,
}

/// A closed contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoggedContact {
    /// The link.
    pub a: String,
    /// The obstacle, or another link.
    pub b: String,
    /// The contact point, in the world (m).
    pub position: [f64; 3],
    /// The unit normal from b to a.
    pub normal: [f64; 3],
    /// The force on a (N).
    pub force: [f64; 3],
    /// Negative where they overlap (m).
    pub gap: f64,
    /// `stick` or `slip`.
    pub state: String,
}

/// The joints of one number in a sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointStates {
    /// Names.
    pub names: Vec<String>,
    /// Positions [rad, m].
    pub positions: Vec<f64>,
    /// Velocities [rad/s, m/s].
    pub velocities: Vec<f64>,
    /// Efforts along the axes [N m, N]; empty if the log has none.
    pub efforts: Vec<f64>,
}

/// The other joints of a sample, or what joints carry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MultiDofStates {
    /// Names.
    pub names: Vec<String>,
    /// Translation (m) and rotation as w, x, y, z.
    pub transforms: Vec<([f64; 3], [f64; 4])>,
    /// Linear and angular velocity [m/s, rad/s].
    pub twists: Vec<([f64; 3], [f64; 3])>,
    /// Force (N) and torque [N m].
    pub wrenches: Vec<([f64; 3], [f64; 3])>,
}

/// Decodes a `tf2_msgs/msg/TFMessage`.
///
/// # Errors
/// The defect of the message.
pub fn transforms(data: &[u8]) -> Result<Vec<LinkPose>, String> {
    CdrReader::new(data)?.sequence(|cdr| {
        cdr.header()?;
        let link = cdr.string()?;
        let [x, y, z, qx, qy, qz, qw] = cdr.numbers()?;
        Ok(LinkPose { link, position: [x, y, z], orientation: [qw, qx, qy, qz] })
    })
}

/// Decodes a `rcl_interfaces/msg/Log`.
///
/// # Errors
/// The defect of the message.
pub fn log_line(data: &[u8]) -> Result<LogLine, String> {
    let mut cdr = CdrReader::new(data)?;
    cdr.time()?;
    let [said] = cdr.aligned()?;
    let _name = cdr.string()?;
    Ok(LogLine { is_problem: said >= level(Severity::Warning), text: cdr.string()? })
}

/// Decodes a message of numbers with names: `catena_msgs/msg/Energy`, `Constraint`, `Solver`.
///
/// # Errors
/// The defect of the message.
pub fn named_numbers<const N: usize>(data: &[u8]) -> Result<[f64; N], String> {
    let mut cdr = CdrReader::new(data)?;
    cdr.header()?;
    cdr.numbers()
}

/// Decodes a `catena_msgs/msg/Event`.
///
/// # Errors
/// The defect of the message.
pub fn event(data: &[u8]) -> Result<LoggedEvent, String> {
    let mut cdr = CdrReader::new(data)?;
    cdr.header()?;
    let [time] = cdr.numbers()?;
    let (kind, what) = (cdr.string()?, cdr.string()?);
    let [impulse] = cdr.numbers()?;
    Ok(LoggedEvent { time, kind, what, impulse: Some(impulse).filter(|impulse| !impulse.is_nan()) })
}

/// Decodes a `catena_msgs/msg/Contacts`.
///
/// # Errors
/// The defect of the message.
pub fn contacts(data: &[u8]) -> Result<Vec<LoggedContact>, String> {
    let mut cdr = CdrReader::new(data)?;
    cdr.header()?;
    cdr.sequence(|cdr| {
        let (a, b) = (cdr.string()?, cdr.string()?);
        let (position, normal, force) = (cdr.numbers()?, cdr.numbers()?, cdr.numbers()?);
        let [gap] = cdr.numbers()?;
        Ok(LoggedContact { a, b, position, normal, force, gap, state: cdr.string()? })
    })
}

/// Decodes a `sensor_msgs/msg/JointState`.
///
/// # Errors
/// The defect of the message.
pub fn joint_states(data: &[u8]) -> Result<JointStates, String> {
    let mut cdr = CdrReader::new(data)?;
    cdr.header()?;
    let states = JointStates {
        names: cdr.strings()?,
        positions: cdr.doubles()?,
        velocities: cdr.doubles()?,
        efforts: cdr.doubles()?,
    };
    let count = states.names.len();
    let fits = |numbers: &Vec<f64>| numbers.is_empty() || numbers.len() == count;
    if fits(&states.positions) && fits(&states.velocities) && fits(&states.efforts) {
        Ok(states)
    } else {
        Err(format!("it names {count} joints and has other counts of numbers"))
    }
}

/// Decodes a `sensor_msgs/msg/JointState` about a frame, and the name of that.
///
/// # Errors
/// The defect of the message.
pub fn framed_joint_states(data: &[u8]) -> Result<(String, JointStates), String> {
    let mut cdr = CdrReader::new(data)?;
    let frame = cdr.frame()?;
    Ok((frame, joint_states(data)?))
}

/// Decodes a `sensor_msgs/msg/MultiDOFJointState`.
///
/// # Errors
/// The defect of the message.
pub fn multi_dof_states(data: &[u8]) -> Result<MultiDofStates, String> {
    let mut cdr = CdrReader::new(data)?;
    cdr.header()?;
    let names = cdr.strings()?;
    let transforms = cdr.sequence(|cdr| {
        let [x, y, z, qx, qy, qz, qw] = cdr.numbers::<7>()?;
        Ok(([x, y, z], [qw, qx, qy, qz]))
    })?;
    let pairs = |cdr: &mut CdrReader| {
        let [a, b, c, d, e, f] = cdr.numbers::<6>()?;
        Ok(([a, b, c], [d, e, f]))
    };
    let twists = cdr.sequence(pairs)?;
    let wrenches = cdr.sequence(pairs)?;
    let counts = [transforms.len(), twists.len(), wrenches.len()];
    if counts.iter().all(|&count| count == 0 || count == names.len()) {
        Ok(MultiDofStates { names, transforms, twists, wrenches })
    } else {
        Err(format!("it names {} joints and has other counts of numbers", names.len()))
    }
}

/// Decodes a `std_msgs/msg/String`.
///
/// # Errors
/// The defect of the message.
pub fn string(data: &[u8]) -> Result<String, String> {
    CdrReader::new(data)?.string()
}

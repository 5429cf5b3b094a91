//! Decodes the messages that [`crate::output::log::Recorder`] writes.
//!
//! CDR as in [`crate::output::log::cdr`], read with every length checked: a damaged message is an error, never a panic or a huge
//! allocation.

use foxglove::Decode;
use foxglove::messages::{FrameTransforms, Log};

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

/// A line of `/log`.
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
    /// What happened.
    pub kind: String,
    /// The joint to which it happened.
    pub what: String,
    /// The impulse of an impact [N m s or N s].
    pub impulse: Option<f64>,
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
    /// Efforts along the axes [N m, N]; empty in logs of earlier versions.
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

/// Decodes a `foxglove.FrameTransforms`.
///
/// # Errors
/// What is wrong with it.
pub fn transforms(data: &[u8]) -> Result<Vec<LinkPose>, String> {
    let decoded = FrameTransforms::decode(data).map_err(|error| error.to_string())?;
    let pose = |transform: foxglove::messages::FrameTransform| {
        let translation = transform.translation.unwrap_or_default();
        let turn = transform.rotation.unwrap_or_default();
        LinkPose {
            link: transform.child_frame_id,
            position: [translation.x, translation.y, translation.z],
            orientation: [turn.w, turn.x, turn.y, turn.z],
        }
    };
    Ok(decoded.transforms.into_iter().map(pose).collect())
}

/// Decodes a `foxglove.Log`.
///
/// # Errors
/// What is wrong with it.
pub fn log_line(data: &[u8]) -> Result<LogLine, String> {
    let line = Log::decode(data).map_err(|error| error.to_string())?;
    let warning = foxglove::messages::log::Level::Warning as i32;
    Ok(LogLine { is_problem: line.level >= warning, text: line.message })
}

/// Decodes a `catena_msgs/msg/Event`.
///
/// # Errors
/// What is wrong with it.
pub fn event(data: &[u8]) -> Result<LoggedEvent, String> {
    let mut cdr = CdrReader::new(data)?;
    cdr.header()?;
    let [time] = cdr.numbers()?;
    let (kind, what) = (cdr.string()?, cdr.string()?);
    let [impulse] = cdr.numbers()?;
    Ok(LoggedEvent { time, kind, what, impulse: Some(impulse).filter(|impulse| !impulse.is_nan()) })
}

/// Decodes a `sensor_msgs/msg/JointState`.
///
/// # Errors
/// What is wrong with it.
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

/// Decodes a `sensor_msgs/msg/MultiDOFJointState`.
///
/// # Errors
/// What is wrong with it.
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

/// Decodes a `std_msgs/msg/Float64MultiArray` of one dimension.
///
/// # Errors
/// What is wrong with it.
pub fn figures(data: &[u8]) -> Result<Vec<f64>, String> {
    let mut cdr = CdrReader::new(data)?;
    cdr.sequence(|cdr| {
        cdr.string()?;
        cdr.unsigned()?;
        cdr.unsigned()
    })?;
    cdr.unsigned()?;
    cdr.doubles()
}

/// Decodes a `std_msgs/msg/String`.
///
/// # Errors
/// What is wrong with it.
pub fn string(data: &[u8]) -> Result<String, String> {
    CdrReader::new(data)?.string()
}

/// Reads one message.
struct CdrReader<'d> {
    data: &'d [u8],
    at: usize,
}

impl<'d> CdrReader<'d> {
    fn new(data: &'d [u8]) -> Result<Self, String> {
        match data.split_at_checked(4) {
            Some(([0, 1, _, _], data)) => Ok(CdrReader { data, at: 0 }),
            _ => Err("it is not little-endian CDR".to_string()),
        }
    }

    fn bytes(&mut self, count: usize) -> Result<&'d [u8], String> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.data.len());
        let end = end.ok_or_else(|| format!("it ends after {} bytes", self.data.len()))?;
        let bytes = &self.data[self.at..end];
        self.at = end;
        Ok(bytes)
    }

    fn aligned<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.at = self.at.next_multiple_of(N);
        self.bytes(N)?.try_into().map_err(|_| "it ends too early".to_string())
    }

    fn unsigned(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.aligned()?))
    }

    fn string(&mut self) -> Result<String, String> {
        let length = self.unsigned()? as usize;
        let bytes = self.bytes(length)?;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        String::from_utf8(text.to_vec()).map_err(|_| "a name is not UTF-8".to_string())
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.aligned()?);
        }
        Ok(numbers)
    }

    fn sequence<T>(&mut self, mut element: impl FnMut(&mut Self) -> Result<T, String>) -> Result<Vec<T>, String> {
        let count = self.unsigned()?;
        // Grown as elements come, because a damaged count may be anything.
        let mut all = Vec::new();
        for _ in 0..count {
            all.push(element(self)?);
        }
        Ok(all)
    }

    fn strings(&mut self) -> Result<Vec<String>, String> {
        self.sequence(Self::string)
    }

    fn doubles(&mut self) -> Result<Vec<f64>, String> {
        self.sequence(|cdr| Ok(f64::from_le_bytes(cdr.aligned()?)))
    }

    /// A `std_msgs/Header`.
    fn header(&mut self) -> Result<(), String> {
        self.unsigned()?;
        self.unsigned()?;
        self.string().map(drop)
    }
}

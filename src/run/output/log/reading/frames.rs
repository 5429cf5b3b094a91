//! A log as a row of frames: everything that is known of one sampled instant.
//!
//! The messages of a sample have the same time. Figures of a step belong to its end. A frame has the figures of the last step that ended at or before
//! it. A sample that lacks messages, because the log ends in it or a chunk is lost, is no frame: in our logs a whole one has a message of every topic
//! of [`TOPICS`] that the log has.

use crate::output::log::encoding::definitions::SENSITIVITIES;
use crate::output::log::encoding::line;
use crate::output::log::encoding::names::LIBRARY;
use crate::output::log::encoding::time::seconds;
use crate::output::log::reading::decode;
use crate::output::log::reading::decode::{JointStates, LinkPose, LogLine, LoggedContact, LoggedEvent, MultiDofStates};
use crate::output::log::reading::reader::{Item, LogChannel, read_log};
use crate::output::log::reading::records::{Completeness, FROM_SOME_PLACE, ReadError};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

/// One sampled instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Its time in nanoseconds.
    pub nanoseconds: u64,
    /// Every link.
    pub links: Vec<LinkPose>,
    /// The joints of one number.
    pub joints: JointStates,
    /// The other joints.
    pub multi_dof: MultiDofStates,
    /// The wrenches of the joints, in the world.
    pub reactions: MultiDofStates,
    /// The efforts of motors.
    pub motors: JointStates,
    /// The closed contacts.
    pub contacts: Vec<LoggedContact>,
    /// Figures of the last step.
    pub figures: Figures,
    /// The last derivatives by each parameter.
    pub slopes: Vec<Slopes>,
}

/// The derivatives of a run by a parameter, at the end of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slopes {
    /// Time at the end of the step in nanoseconds.
    pub nanoseconds: u64,
    /// The parameter.
    pub key: String,
    /// ∂q/∂θ and ∂v/∂θ of the degrees of freedom.
    pub by: JointStates,
}

/// The figures at the end of a step; `None` where the log has no such figure yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Time at the end of the step in nanoseconds.
    pub nanoseconds: u64,
    /// Kinetic, potential and total energy; since the start dissipated, work put in, lost to dry friction and in impacts (J).
    pub energy: Option<[f64; 7]>,
    /// Violation of positions [m, rad] and velocities [m/s, rad/s].
    pub violation: Option<[f64; 2]>,
    /// Last step (s), stages, and since the figures before: steps, iterations, rejected steps.
    pub solver: Option<[f64; 5]>,
}

impl Figures {
    /// The time at the end of the step (s).
    pub fn time(&self) -> f64 {
        seconds(self.nanoseconds)
    }

    /// The energy balance, which should be the same in all figures of a run (J): the total energy with all energy dissipated or lost, and without the
    /// work that was put in.
    pub fn balance(&self) -> Option<f64> {
        self.energy.map(|[_, _, total, dissipated, work, friction, impacts]| {
            total + ((dissipated - work) + friction + impacts)
        })
    }
}

impl Frame {
    /// Its time (s).
    pub fn time(&self) -> f64 {
        seconds(self.nanoseconds)
    }

    /// Whether it has joints: logs of chosen topics may lack them.
    pub fn has_joints(&self) -> bool {
        !(self.joints.names.is_empty() && self.multi_dof.names.is_empty())
    }
}

/// The topics of a frame, and the schemas of their messages.
const TOPICS: [(&str, &str); 6] = [
    ("/tf", "tf2_msgs/msg/TFMessage"),
    ("/joint_states", "sensor_msgs/msg/JointState"),
    ("/multi_dof_joint_states", "sensor_msgs/msg/MultiDOFJointState"),
    ("/reactions", "sensor_msgs/msg/MultiDOFJointState"),
    ("/motors", "sensor_msgs/msg/JointState"),
    ("/contacts", "catena_msgs/msg/Contacts"),
];

/// Which of [`TOPICS`] a channel has.
fn topic_of(channel: &LogChannel) -> Option<usize> {
    TOPICS.iter().position(|(topic, schema)| channel.topic == *topic && channel.schema == *schema)
}

/// Receives the items of a log besides frames.
pub trait Visitor {
    /// A sampled instant.
    fn frame(&mut self, _frame: &Frame) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// The figures of a step, in order of time.
    fn figures(&mut self, _figures: &Figures) {}

    /// The derivatives by a parameter at the end of a step.
    fn slopes(&mut self, _slopes: &Slopes) {}

    /// An event.
    fn event(&mut self, _event: LoggedEvent) {}

    /// A message of any kind, before it is decoded.
    fn message(&mut self, _channel: &LogChannel, _nanoseconds: u64) {}

    /// A line of text.
    fn line(&mut self, _nanoseconds: u64, _line: LogLine) {}

    /// A channel.
    fn channel(&mut self, _channel: &LogChannel) {}

    /// A metadata record.
    fn metadata(&mut self, _name: &str, _entries: &BTreeMap<String, String>) {}

    /// An attachment.
    fn attachment(&mut self, _name: &str, _media_type: &str, _data: &[u8]) {}
}

/// Shows a log to a visitor; `None` if that broke off.
///
/// # Errors
/// [`ReadError`] if it is not a log.
pub fn visit(path: &Path, visitor: &mut dyn Visitor) -> Result<Option<Completeness>, ReadError> {
    let mut builder = Builder {
        frame: None,
        figures: None,
        last: Figures::default(),
        slopes: Vec::new(),
        is_ours: false,
        declared: [false; TOPICS.len()],
        seen: [false; TOPICS.len()],
        is_torn: false,
        visitor,
        problem: None,
    };
    let ended = read_log(path, |item| match item {
        Item::Library(name) => {
            builder.is_ours = name.starts_with(LIBRARY);
            ControlFlow::Continue(())
        }
        Item::Channel(channel) => {
            if let Some(topic) = topic_of(channel) {
                builder.declared[topic] = true;
            }
            builder.visitor.channel(channel);
            ControlFlow::Continue(())
        }
        Item::Metadata { name, entries } => {
            builder.visitor.metadata(name, entries);
            ControlFlow::Continue(())
        }
        Item::Attachment { name, media_type, data } => {
            builder.visitor.attachment(name, media_type, data);
            ControlFlow::Continue(())
        }
        Item::LostChunk(_) => {
            // Some messages of the sample before it may be in it, and of the one after it.
            builder.is_torn = true;
            let flow = builder.flush();
            builder.is_torn = true;
            flow
        }
        Item::Message { channel, time, data } => {
            builder.visitor.message(channel, time);
            match builder.message(channel, time, data) {
                Ok(flow) => flow,
                Err(reason) => {
                    let (topic, time) = (&channel.topic, seconds(time));
                    builder.problem = Some(format!("topic {topic} at t = {time} s: {reason}"));
                    ControlFlow::Break(())
                }
            }
        }
    })?;
    // Messages before a damaged one are as good as ever.
    let ended = match builder.problem.take() {
        Some(problem) => {
            let broken_off = Some(format!("{FROM_SOME_PLACE}: {problem}"));
            Some(Completeness { damaged: true, broken_off, ..Completeness::default() })
        }
        None => ended,
    };
    // The messages of a sample are not written at once: of the last one of a killed run some may be missing.
    builder.is_torn = true;
    if ended.is_some() && builder.flush().is_break() {
        return Ok(None);
    }
    Ok(ended)
}

struct Builder<'v> {
    frame: Option<Frame>,
    figures: Option<Figures>,
    last: Figures,
    /// The last derivatives by each parameter.
    slopes: Vec<Slopes>,
    /// Whether this program wrote the log, so that every sample has a message of every topic.
    is_ours: bool,
    /// Which of [`TOPICS`] the log has,
    declared: [bool; TOPICS.len()],
    /// and which the frame.
    seen: [bool; TOPICS.len()],
    /// Whether messages may be missing of the frame, whoever wrote the log.
    is_torn: bool,
    visitor: &'v mut dyn Visitor,
    /// The defect of the message at which reading has ended.
    problem: Option<String>,
}

impl Builder<'_> {
    fn message(&mut self, channel: &LogChannel, time: u64, data: &[u8]) -> Result<ControlFlow<()>, String> {
        // Logs of others may go back in time, too.
        let another = self.frame.as_ref().is_some_and(|frame| time != frame.nanoseconds)
            || self.figures.is_some_and(|figures| time != figures.nanoseconds);
        if another && self.flush().is_break() {
            return Ok(ControlFlow::Break(()));
        }
        let new_frame = || Frame { nanoseconds: time, ..Frame::default() };
        let new_figures = || Figures { nanoseconds: time, ..Figures::default() };
        // Others may use the same topics for other messages.
        match (channel.topic.as_str(), channel.schema.as_str()) {
            ("/tf", "tf2_msgs/msg/TFMessage") => {
                self.frame.get_or_insert_with(new_frame).links = decode::transforms(data)?;
            }
            ("/joint_states", "sensor_msgs/msg/JointState") => {
                self.frame.get_or_insert_with(new_frame).joints = decode::joint_states(data)?;
            }
            ("/multi_dof_joint_states", "sensor_msgs/msg/MultiDOFJointState") => {
                self.frame.get_or_insert_with(new_frame).multi_dof = decode::multi_dof_states(data)?;
            }
            ("/reactions", "sensor_msgs/msg/MultiDOFJointState") => {
                self.frame.get_or_insert_with(new_frame).reactions = decode::multi_dof_states(data)?;
            }
            ("/motors", "sensor_msgs/msg/JointState") => {
                self.frame.get_or_insert_with(new_frame).motors = decode::joint_states(data)?;
            }
            ("/contacts", "catena_msgs/msg/Contacts") => {
                self.frame.get_or_insert_with(new_frame).contacts = decode::contacts(data)?;
            }
            ("/events", "catena_msgs/msg/Event") => self.visitor.event(decode::event(data)?),
            ("/energy", "catena_msgs/msg/Energy") => {
                let energy = decode::named_numbers(data)?;
                self.figures.get_or_insert_with(new_figures).energy = Some(energy);
            }
            ("/constraint", "catena_msgs/msg/Constraint") => {
                let violation = decode::named_numbers(data)?;
                self.figures.get_or_insert_with(new_figures).violation = Some(violation);
            }
            ("/solver", "catena_msgs/msg/Solver") => {
                let solver = decode::named_numbers(data)?;
                self.figures.get_or_insert_with(new_figures).solver = Some(solver);
            }
            (topic, "sensor_msgs/msg/JointState") if topic.starts_with(SENSITIVITIES) => {
                let (key, by) = decode::framed_joint_states(data)?;
                let slopes = Slopes { nanoseconds: time, key, by };
                self.visitor.slopes(&slopes);
                match self.slopes.iter_mut().find(|known| known.key == slopes.key) {
                    Some(known) => *known = slopes,
                    None => self.slopes.push(slopes),
                }
            }
            (line::TOPIC, "rcl_interfaces/msg/Log") => self.visitor.line(time, decode::log_line(data)?),
            _ => {}
        }
        if let Some(topic) = topic_of(channel) {
            self.seen[topic] = true;
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Shows complete items: the figures first, because a frame has the figures of its own time.
    fn flush(&mut self) -> ControlFlow<()> {
        if let Some(figures) = self.figures.take() {
            self.visitor.figures(&figures);
            self.last = figures;
        }
        let may_lack = std::mem::take(&mut self.is_torn) || self.is_ours;
        let lacks = std::mem::take(&mut self.seen) != self.declared;
        match self.frame.take() {
            Some(frame) if !(may_lack && lacks) => {
                self.visitor.frame(&Frame { figures: self.last, slopes: self.slopes.clone(), ..frame })
            }
            _ => ControlFlow::Continue(()),
        }
    }
}

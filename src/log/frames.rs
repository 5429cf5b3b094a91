//! A log as a row of frames: everything that is known of one sampled instant.
//!
//! The messages of a sample have the same time. Figures of a step belong to its end; a frame has those of the last step
//! that ended at or before it. A sample that lacks messages, because the log ends in it or a chunk is lost, is no frame.

use super::decode::{self, JointStates, LinkPose, LogLine, MultiDofStates};
use super::reader::{Completeness, Item, LogChannel, ReadError, read_log};
use super::seconds;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

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
    /// What the joints carry, in the world.
    pub reactions: MultiDofStates,
    /// Figures of the last step.
    pub figures: Figures,
}

/// The figures at the end of a step; `None` where the log has none yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Time at the end of the step in nanoseconds.
    pub nanoseconds: u64,
    /// Kinetic, potential and total energy; since the start dissipated, and work put in (J).
    pub energy: Option<[f64; 5]>,
    /// Violation of positions [m, rad] and velocities [m/s, rad/s].
    pub violation: Option<[f64; 2]>,
    /// Last step (s), stages, and since the figures before: steps, iterations, rejected steps.
    pub solver: Option<[f64; 5]>,
}

impl Figures {
    /// What should be the same in all figures of a run (J): the total energy with what was dissipated and without the
    /// work that was put in.
    pub fn balance(&self) -> Option<f64> {
        self.energy.map(|[_, _, total, dissipated, work]| total + (dissipated - work))
    }
}

impl Frame {
    /// Its time (s).
    pub fn time(&self) -> f64 {
        seconds(self.nanoseconds)
    }

    /// How many links, joints and reactions it has.
    fn shape(&self) -> [usize; 4] {
        [self.links.len(), self.joints.names.len(), self.multi_dof.names.len(), self.reactions.names.len()]
    }
}

/// What a log has besides frames.
pub trait Visitor {
    /// A sampled instant.
    fn frame(&mut self, _frame: &Frame) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// The figures of a step, in order of time.
    fn figures(&mut self, _figures: &Figures) {}

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
/// [`ReadError`] if it is not a log, or a message of it is not what it should be.
pub fn visit(path: &Path, visitor: &mut dyn Visitor) -> Result<Option<Completeness>, ReadError> {
    let mut builder = Builder {
        frame: None,
        figures: None,
        last: Figures::default(),
        shape: None,
        is_torn: false,
        visitor,
        problem: None,
    };
    let ended = read_log(path, |item| match item {
        Item::Library(_) => ControlFlow::Continue(()),
        Item::Channel(channel) => {
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
                    builder.problem = Some(ReadError::Message {
                        path: path.to_path_buf(),
                        topic: channel.topic.clone(),
                        time: seconds(time),
                        reason,
                    });
                    ControlFlow::Break(())
                }
            }
        }
    })?;
    if let Some(problem) = builder.problem.take() {
        return Err(problem);
    }
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
    /// That of the last frame.
    shape: Option<[usize; 4]>,
    /// Whether messages may be missing of the frame.
    is_torn: bool,
    visitor: &'v mut dyn Visitor,
    problem: Option<ReadError>,
}

impl Builder<'_> {
    fn message(&mut self, channel: &LogChannel, time: u64, data: &[u8]) -> Result<ControlFlow<()>, String> {
        let later = self.frame.as_ref().is_some_and(|frame| time > frame.nanoseconds)
            || self.figures.is_some_and(|figures| time > figures.nanoseconds);
        if later && self.flush().is_break() {
            return Ok(ControlFlow::Break(()));
        }
        let new_frame = || Frame { nanoseconds: time, ..Frame::default() };
        let new_figures = || Figures { nanoseconds: time, ..Figures::default() };
        // Others may use the same topics for other messages.
        match (channel.topic.as_str(), channel.schema.as_str()) {
            ("/tf", "foxglove.FrameTransforms") => {
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
            ("/energy", "std_msgs/msg/Float64MultiArray") => {
                let mut energy = decode::figures(data)?;
                // Logs of earlier versions are of runs in which nothing was exchanged.
                energy.resize(5, 0.0);
                let energy = energy.first_chunk().copied();
                self.figures.get_or_insert_with(new_figures).energy = energy;
            }
            ("/constraint", "std_msgs/msg/Float64MultiArray") => {
                let violation = decode::figures(data)?.first_chunk().copied();
                self.figures.get_or_insert_with(new_figures).violation = violation;
            }
            ("/solver", "std_msgs/msg/Float64MultiArray") => {
                let solver = decode::figures(data)?.first_chunk().copied();
                self.figures.get_or_insert_with(new_figures).solver = solver;
            }
            ("/log", "foxglove.Log") => self.visitor.line(time, decode::log_line(data)?),
            _ => {}
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Shows what is complete: the figures first, because a frame has those of its own time.
    fn flush(&mut self) -> ControlFlow<()> {
        if let Some(figures) = self.figures.take() {
            self.visitor.figures(&figures);
            self.last = figures;
        }
        if std::mem::take(&mut self.is_torn) {
            let shape = self.shape;
            self.frame.take_if(|frame| shape.is_some_and(|shape| shape != frame.shape()));
        }
        match self.frame.take() {
            Some(frame) => {
                self.shape = Some(frame.shape());
                self.visitor.frame(&Frame { figures: self.last, ..frame })
            }
            None => ControlFlow::Continue(()),
        }
    }
}

/// Frames that are handed over together.
const PIECE: usize = 64;

/// Some frames, and how much of the log there was if they are the last.
type FramePiece = (Vec<Frame>, Option<Completeness>);

/// The frames of a log one after the other, read by a thread.
pub struct Frames {
    receiver: Receiver<Result<FramePiece, ReadError>>,
    ready: std::vec::IntoIter<Frame>,
    completeness: Option<Completeness>,
}

impl Frames {
    /// Starts to read a log.
    ///
    /// # Errors
    /// [`ReadError::Io`] if there can be no thread.
    pub fn of(path: &Path) -> Result<Self, ReadError> {
        let (sender, receiver) = sync_channel(4);
        let log = path.to_path_buf();
        let read = move || {
            let mut collector = Sender { sender, piece: Vec::new() };
            let ended = visit(&log, &mut collector);
            let _ = collector.sender.send(ended.map(|completeness| (collector.piece, completeness)));
        };
        let thread = std::thread::Builder::new().name("log".to_string()).spawn(read);
        thread.map_err(|reason| ReadError::Io { path: path.to_path_buf(), reason })?;
        Ok(Frames { receiver, ready: Vec::new().into_iter(), completeness: None })
    }

    /// How much of the log there was, once there are no more frames.
    pub fn completeness(&self) -> Option<&Completeness> {
        self.completeness.as_ref()
    }
}

impl Iterator for Frames {
    type Item = Result<Frame, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(frame) = self.ready.next() {
                return Some(Ok(frame));
            }
            match self.receiver.recv() {
                Ok(Ok((piece, completeness))) => (self.ready, self.completeness) = (piece.into_iter(), completeness),
                Ok(Err(error)) => return Some(Err(error)),
                // The thread has ended: there are no more.
                Err(_) => return None,
            }
        }
    }
}

struct Sender {
    sender: SyncSender<Result<FramePiece, ReadError>>,
    piece: Vec<Frame>,
}

impl Visitor for Sender {
    fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
        self.piece.push(frame.clone());
        if self.piece.len() < PIECE || self.sender.send(Ok((std::mem::take(&mut self.piece), None))).is_ok() {
            ControlFlow::Continue(())
        } else {
            // Nobody wants to see any more.
            ControlFlow::Break(())
        }
    }
}

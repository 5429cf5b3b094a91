//! Compares the messages of a run with the messages of a log, bit for bit.
//!
//! A thread reads the log. Messages that do not depend on the run (descriptions, lines of text) are passed over on both sides.

use crate::output::log::encoding::definitions::Definition;
use crate::output::log::encoding::definitions::SENSITIVITIES;
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::line::TOPIC as LINES;
use crate::output::log::encoding::markers::TOPIC as MARKERS;
use crate::output::log::encoding::time::seconds;
use crate::output::log::messages::collision_shapes::TOPIC as SHAPES;
use crate::output::log::reading::decode;
use crate::output::log::reading::reader::{Item, read_log};
use crate::output::log::storage::batch::Batch;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};

/// Messages that are handed over together.
const PIECE: usize = 256;

/// Topics that are not compared: they hold paths of the machine and words, or follow from the run.
fn is_compared(topic: &str) -> bool {
    !(topic.starts_with(SENSITIVITIES)
        || topic.ends_with("robot_description")
        || [MARKERS, SHAPES, LINES, "/scene", "/log"].contains(&topic))
}

/// The first message of a run that differs from the log.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Difference {
    /// They say different things.
    #[error("{topic} differs at t = {time} s: {what}")]
    Message { topic: String, time: f64, what: String },
    /// The log has messages of another kind.
    #[error(
        "{topic} has messages of the kind {logged} in the log, and this version writes {written}; replay the log with the version that \
         wrote it, or look at it with `catena inspect`"
    )]
    Kind { topic: String, logged: String, written: &'static str },
    /// The log has no more messages.
    #[error("the log ends at t = {time} s")]
    LogEnded { time: f64 },
    /// The log has messages that the run has not.
    #[error("the log goes on after the end of the run, with {topic} at t = {time} s")]
    LogGoesOn { topic: String, time: f64 },
    /// The log cannot be read, or not any further.
    #[error("the log cannot be compared after t = {time} s: {reason}")]
    Unreadable { time: f64, reason: String },
}

/// How much was found to be the same.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Compared {
    /// Messages.
    pub messages: usize,
    /// Time of the last of them (s).
    pub time: f64,
}

struct Message {
    topic: String,
    schema: String,
    time: u64,
    data: Vec<u8>,
}

/// A log that is compared with.
pub(crate) struct Comparison {
    /// The time of messages at the start of the run, in nanoseconds.
    start: u64,
    /// The topics of the run, and the kinds of their messages.
    topics: Vec<(String, &'static str)>,
    piece: Batch,
    expected: std::vec::IntoIter<Message>,
    receiver: Receiver<Result<Vec<Message>, String>>,
    /// Whether all of the log has been handed over.
    has_ended: bool,
    compared: Compared,
    found: Option<Difference>,
}

impl Comparison {
    /// Starts to read a log.
    pub(crate) fn new(path: &Path, start: u64) -> Result<Self, LogError> {
        let (sender, receiver) = sync_channel(4);
        let log: PathBuf = path.to_path_buf();
        let read = move || {
            let (mut piece, mut damage) = (Vec::new(), None);
            let ended = read_log(&log, |item| {
                let (channel, time, data) = match item {
                    Item::Message { channel, time, data } => (channel, time, data),
                    Item::LostChunk(reason) => {
                        damage = Some(format!("a chunk cannot be read: {reason}"));
                        return ControlFlow::Break(());
                    }
                    _ => return ControlFlow::Continue(()),
                };
                if is_compared(&channel.topic) {
                    let (topic, schema) = (channel.topic.clone(), channel.schema.clone());
                    piece.push(Message { topic, schema, time, data: data.to_vec() });
                }
                if piece.len() < PIECE || sender.send(Ok(std::mem::take(&mut piece))).is_ok() {
                    ControlFlow::Continue(())
                } else {
                    // The receiver of the messages is gone.
                    ControlFlow::Break(())
                }
            });
            // The messages before the damage are compared all the same.
            if !piece.is_empty() {
                let _ = sender.send(Ok(piece));
            }
            let damage = match ended {
                Ok(Some(completeness)) if completeness.damaged => completeness.broken_off,
                Ok(_) => damage,
                Err(error) => Some(error.to_string()),
            };
            let _ = sender.send(damage.map_or(Ok(Vec::new()), Err));
        };
        let thread = std::thread::Builder::new().name("log".to_string()).spawn(read);
        thread.map_err(|reason| LogError::Write { path: path.to_path_buf(), reason })?;
        Ok(Comparison {
            start,
            topics: Vec::new(),
            piece: Batch::default(),
            expected: Vec::new().into_iter(),
            receiver,
            has_ended: false,
            compared: Compared::default(),
            found: None,
        })
    }

    /// Restarts from the start of the log, which is at `path`.
    ///
    /// # Errors
    /// As of [`Comparison::new`].
    pub(crate) fn begin_again(&mut self, path: &Path) -> Result<(), LogError> {
        *self = Comparison { topics: std::mem::take(&mut self.topics), ..Comparison::new(path, self.start)? };
        Ok(())
    }

    fn next(&mut self) -> Result<Option<Message>, Difference> {
        loop {
            if let Some(message) = self.expected.next() {
                return Ok(Some(message));
            }
            if self.has_ended {
                return Ok(None);
            }
            match self.receiver.recv() {
                // The last one is empty.
                Ok(Ok(piece)) if piece.is_empty() => self.has_ended = true,
                Ok(Ok(piece)) => self.expected = piece.into_iter(),
                Ok(Err(reason)) => return Err(Difference::Unreadable { time: self.compared.time, reason }),
                // A thread that ends without a last piece has broken off.
                Err(_) => {
                    let reason = "what reads it has broken off".to_string();
                    return Err(Difference::Unreadable { time: self.compared.time, reason });
                }
            }
        }
    }

    /// Compares the content of the piece.
    ///
    /// # Errors
    /// The first [`Difference`], also if it was found before.
    pub(crate) fn settle(&mut self) -> Result<(), Difference> {
        if let Some(found) = &self.found {
            return Err(found.clone());
        }
        let piece = std::mem::take(&mut self.piece);
        let result = piece.messages().try_for_each(|(entry, data)| {
            let (topic, schema) = self.topics.get(usize::from(entry.channel)).cloned().unwrap_or_default();
            let time = entry.time.saturating_sub(self.start);
            if is_compared(&topic) { self.compare((&topic, schema), time, data) } else { Ok(()) }
        });
        if let Err(difference) = &result {
            self.found = Some(difference.clone());
        }
        result
    }

    fn compare(&mut self, (topic, schema): (&str, &'static str), time: u64, data: &[u8]) -> Result<(), Difference> {
        let Some(expected) = self.next()? else { return Err(Difference::LogEnded { time: self.compared.time }) };
        let differs = |what: String| Err(Difference::Message { topic: topic.to_string(), time: seconds(time), what });
        if (expected.topic.as_str(), expected.time) != (topic, time) {
            return differs(format!("the log has {} at t = {} s there", expected.topic, seconds(expected.time)));
        }
        if expected.schema != schema {
            let (topic, logged) = (topic.to_string(), expected.schema);
            return Err(Difference::Kind { topic, logged, written: schema });
        }
        if expected.data != data {
            return differs(what_differs(topic, &expected.data, data));
        }
        self.compared = Compared { messages: self.compared.messages + 1, time: seconds(time) };
        Ok(())
    }

    /// Ends the comparison.
    pub(crate) fn finish(mut self) -> (Compared, Result<(), Difference>) {
        let ended = self.settle().and_then(|()| match self.next()? {
            Some(Message { topic, time, .. }) => Err(Difference::LogGoesOn { topic, time: seconds(time) }),
            None => Ok(()),
        });
        (self.compared, ended)
    }
}

/// Says in words how two messages of a topic differ: for poses which link is how far away.
fn what_differs(topic: &str, logged: &[u8], run: &[u8]) -> String {
    let (Some(logged), Some(run)) = (poses(topic, logged), poses(topic, run)) else {
        let place = logged.iter().zip(run).take_while(|(a, b)| a == b).count();
        return format!("not the same from byte {place} on");
    };
    let distance = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let pairs = logged.iter().zip(&run).filter(|(a, b)| a.0 == b.0).map(|(a, b)| (distance(&a.1, &b.1), &a.0));
    match pairs.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((distance, link)) => format!("link {link:?} is {distance:.1e} m from where the log has it"),
        None => "other links".to_string(),
    }
}

fn poses(topic: &str, data: &[u8]) -> Option<Vec<(String, [f64; 3])>> {
    let links = (topic == "/tf").then(|| decode::transforms(data).ok())??;
    Some(links.into_iter().map(|pose| (pose.link, pose.position)).collect())
}

impl MessageSink for Comparison {
    fn channel(&mut self, topic: &str, definition: &Definition, _: Durability) -> Result<u16, LogError> {
        self.topics.push((topic.to_string(), definition.name));
        // There are never more than a few dozen.
        Ok(self.topics.len() as u16 - 1)
    }
    fn message(&mut self, channel: u16, nanoseconds: u64, template: &[u8]) -> Result<&mut [u8], LogError> {
        Ok(self.piece.push(channel, nanoseconds, template))
    }
}

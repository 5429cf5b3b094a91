//! The observer that hands samples and events over to be logged (the table of [`crate::output::log`]).

use crate::lobatto::instants::snapshot::INSTANTS;
use crate::mechanism::motion::event::Event;
use crate::model::Model;
use crate::output::log::background::BackgroundFile;
use crate::output::log::comparison::{Compared, Comparison, Difference};
use crate::output::log::encoder::{SampleEncoder, foxglove_channel};
use crate::output::log::error::LogError;
use crate::output::log::file::{Ending, LogFile, MessageSink};
use crate::output::log::inputs::{attach_inputs, inputs};
use crate::output::log::order::Order;
use crate::output::log::queue::{Between, Piece};
use crate::output::log::ros;
use crate::output::log::ros::ros_channel;
use crate::output::log::standin::{standins, with_standins};
use crate::output::log::visual::Looks;
use crate::simulation::{Observer, ObserverError, Sample};
use foxglove::Encode;
use foxglove::messages::{self, SceneUpdate, Timestamp};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// How serious a line of `/log` is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Something to know.
    Info,
    /// The run goes on.
    Warning,
    /// The run ended.
    Error,
}

/// Writes a run to an MCAP file, or holds it against one.
pub struct Recorder {
    sink: Sink,
    order: Order,
}

/// Where samples go.
enum Sink {
    File(BackgroundFile),
    Comparison(Box<Compare>),
}

/// A comparison, and what makes the messages for it.
struct Compare {
    comparison: Comparison,
    encoder: SampleEncoder,
    piece: Piece,
}

impl Compare {
    fn settle(&mut self) -> Result<(), ObserverError> {
        let encoded = self.encoder.encode(&self.piece, &mut self.comparison);
        self.piece.clear();
        encoded?;
        Ok(self.comparison.settle()?)
    }
}

/// The name of the metadata record that says how a run was made.
pub(crate) const SIMULATION: &str = "simulation";

impl Recorder {
    /// Creates the log of a run whose output is `path`, and writes what is known before the first sample; `simulation`
    /// says how the run is made, and has the hash of the main input added.
    ///
    /// # Errors
    /// [`LogError`] when the file cannot be created or written.
    pub fn create(path: &Path, model: &Model, mut simulation: BTreeMap<String, String>) -> Result<Self, LogError> {
        let mut file = LogFile::create(path)?;
        let inputs = inputs(model);
        simulation.extend(inputs.first().map(|main| ("input_sha256".to_string(), main.hash.clone())));
        let stages = simulation.get("stages").and_then(|stages| stages.parse().ok()).unwrap_or(f64::NAN);
        file.metadata(SIMULATION, simulation)?;
        attach_inputs(&mut file, &inputs)?;
        let encoder = prepare(&mut file, model)?;
        // What never changes is safe in the file before the run begins.
        file.begin()?;
        let file = BackgroundFile::new(path, file, encoder)?;
        Ok(Recorder { sink: Sink::File(file), order: Order::new(stages) })
    }

    /// Waits no more for an output that is no file, and of which nothing is read, once this says that the run is interrupted.
    pub fn heed(&mut self, interrupted: &Arc<AtomicBool>) {
        if let Sink::File(file) = &mut self.sink {
            file.heed(interrupted.clone());
        }
    }

    /// Holds a run against the log at `path`, which a run of the same model made in the same way has written: the first
    /// message that differs is the error of [`Observer::sample`], a [`Difference`], a few samples later.
    ///
    /// # Errors
    /// [`LogError::Write`] if there can be no thread that reads the log.
    pub fn compare(path: &Path, model: &Model, stages: f64) -> Result<Self, LogError> {
        let mut comparison = Comparison::new(path)?;
        let encoder = prepare(&mut comparison, model)?;
        let compare = Compare { comparison, encoder, piece: Piece::default() };
        Ok(Recorder { sink: Sink::Comparison(Box::new(compare)), order: Order::new(stages) })
    }

    /// Lets `add` add to what will be logged; returns whether the sink has something to say.
    fn add(sink: &mut Sink, add: impl FnOnce(&mut Piece)) -> bool {
        match sink {
            Sink::File(file) => file.add(add),
            Sink::Comparison(compare) => {
                add(&mut compare.piece);
                compare.piece.times.len() >= INSTANTS
            }
        }
    }

    /// Adds a line to `/log` at the time of the last message.
    pub fn say(&mut self, severity: Severity, text: &str) {
        let time = self.order.last_time();
        let line = log_line(time, severity, text);
        Self::add(&mut self.sink, |piece| piece.push_between(Between::Line(time, line)));
    }

    /// Where the log is while it is written, if that is beside its output, which must stay until the run has finished.
    pub fn beside(&self) -> Option<&Path> {
        match &self.sink {
            Sink::File(file) => file.is_beside().then(|| file.current()),
            Sink::Comparison(_) => None,
        }
    }

    /// Writes everything that is still in memory and how the run ended, and completes the file.
    ///
    /// # Errors
    /// [`LogError::Write`], also for what earlier messages could not be written for.
    pub fn finish(mut self, ending: Ending) -> Result<(), LogError> {
        Self::add(&mut self.sink, |piece| self.order.add_until(f64::INFINITY, piece));
        match self.sink {
            Sink::File(file) => file.finish(ending).map(drop),
            Sink::Comparison(_) => Ok(()),
        }
    }

    /// Ends a comparison: how much was compared, and the first difference, if any.
    pub fn compared(mut self) -> (Compared, Result<(), Difference>) {
        Self::add(&mut self.sink, |piece| self.order.add_until(f64::INFINITY, piece));
        match self.sink {
            Sink::File(_) => (Compared::default(), Ok(())),
            Sink::Comparison(mut compare) => {
                // What differs is said at the end.
                let _ = compare.settle();
                compare.comparison.finish()
            }
        }
    }
}

impl Observer for Recorder {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        if Self::add(&mut self.sink, |piece| self.order.add(sample, piece)) {
            match &mut self.sink {
                Sink::File(file) => file.settle()?,
                Sink::Comparison(compare) => compare.settle()?,
            }
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) {
        self.order.event(event);
    }
}

/// An encoded line of `/log`.
fn log_line(time: u64, severity: Severity, text: &str) -> Vec<u8> {
    let level = match severity {
        Severity::Info => messages::log::Level::Info,
        Severity::Warning => messages::log::Level::Warning,
        Severity::Error => messages::log::Level::Error,
    };
    let message = messages::Log {
        timestamp: Some(timestamp(time)),
        level: level.into(),
        message: text.to_string(),
        name: "catena".to_string(),
        ..messages::Log::default()
    };
    let mut line = Vec::new();
    encode(&message, &mut line);
    line
}

/// Adds all channels, and the messages that are known before the first sample.
fn prepare(sink: &mut dyn MessageSink, model: &Model) -> Result<SampleEncoder, LogError> {
    let left_out = describe(sink, model)?;
    let encoder = SampleEncoder::new(sink, model)?;
    for warning in model.warnings.iter().map(ToString::to_string).chain(left_out) {
        encoder.line(sink, 0, &log_line(0, Severity::Warning, &warning))?;
    }
    Ok(encoder)
}

/// For viewers each robot's URDF and the looks of all of them; says what could not be put into the log. With several
/// robots all names have the robot's before them, as in the transforms.
fn describe(sink: &mut dyn MessageSink, model: &Model) -> Result<Vec<String>, LogError> {
    let mut buffer = Vec::new();
    let mut looks = Looks::default();
    for (index, placed) in model.robots.iter().enumerate() {
        let (prefix, robot) = (model.prefix(index), &placed.robot);
        let channel = ros_channel(sink, &format!("/{prefix}robot_description"), ros::STRING)?;
        let standins = standins(model, placed);
        let description =
            if prefix.is_empty() { robot.description.clone() } else { robot.prefixed_description(&prefix) };
        ros::encode_string(
            &with_standins(&description, &prefix, &standins, &|link| robot.links[link].name.clone()),
            &mut buffer,
        );
        sink.message(channel, 0, &buffer)?;
        looks.add(&robot.links, &prefix, &standins);
    }
    if !looks.scene.entities.is_empty() {
        let channel = foxglove_channel::<SceneUpdate>(sink, "/scene")?;
        encode(&looks.scene, &mut buffer);
        sink.message(channel, 0, &buffer)?;
    }
    Ok(looks.warnings())
}

/// Encodes into the emptied buffer.
fn encode(message: &impl Encode, buffer: &mut Vec<u8>) {
    buffer.clear();
    // Encoding fails only when the buffer is too small, and a vector grows.
    let _ = message.encode(buffer);
}

fn timestamp(nanoseconds: u64) -> Timestamp {
    let seconds = u32::try_from(nanoseconds / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (nanoseconds % 1_000_000_000) as u32)
}

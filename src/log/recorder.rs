//! The observer that turns samples into messages of the log (the table of [`crate::log`]).
//!
//! Everything that does not change is prepared once: names, message layouts, buffers. The figures of a step belong to
//! its end, which lies after the samples inside the step; they wait for the first sample that is not earlier, so that
//! times never go back in the file.

use super::background::BackgroundFile;
use super::batch::Batch;
use super::comparison::{Compared, Comparison, Difference};
use super::file::{Ending, LogChannels, LogError, LogFile};
use super::inputs::attach_inputs;
use super::joints::JointMessages;
use super::nanoseconds;
use super::ros::{self, ros_channel};
use super::standin::{standins, with_standins};
use super::transforms::TransformsEncoder;
use super::visual::Looks;
use crate::model::joint::wxyz_from_rotation;
use crate::model::{LinkFrame, Model, Pose};
use crate::simulation::{Counts, Observer, ObserverError, Sample, StepEnd};
use foxglove::messages::{self, FrameTransforms, SceneUpdate, Timestamp};
use foxglove::{Encode, Schema};
use std::collections::BTreeMap;
use std::path::Path;

/// The frame all poses are given in, unless a moving link has taken the name.
const WORLD_FRAME: &str = "world";

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
pub struct Recorder<'m> {
    sink: Sink,
    channels: Channels,
    stages: f64,
    links: Vec<LinkFrame>,
    transforms: TransformsEncoder,
    joints: JointMessages<'m>,
    waiting: Option<StepEnd>,
    last_figures: Option<f64>,
    last_counts: Counts,
    last_time: u64,
    buffer: Vec<u8>,
}

/// Where messages go.
enum Sink {
    File(BackgroundFile),
    Comparison(Comparison),
}

impl Sink {
    /// The messages of this sample.
    fn piece(&mut self) -> &mut Batch {
        match self {
            Sink::File(file) => file.piece(),
            Sink::Comparison(comparison) => comparison.piece(),
        }
    }
}

struct Channels {
    log: u16,
    transforms: u16,
    energy: u16,
    constraint: u16,
    solver: u16,
}

/// The name of the metadata record that says how a run was made.
pub(super) const SIMULATION: &str = "simulation";

impl<'m> Recorder<'m> {
    /// Creates the log of a run whose output is `path`, and writes what is known before the first sample; `simulation`
    /// says how the run is made.
    ///
    /// # Errors
    /// [`LogError`] when the file cannot be created or written.
    pub fn create(path: &Path, model: &'m Model, simulation: BTreeMap<String, String>) -> Result<Self, LogError> {
        let mut file = LogFile::create(path)?;
        let stages = simulation.get("stages").and_then(|stages| stages.parse().ok()).unwrap_or(f64::NAN);
        file.metadata(SIMULATION, simulation)?;
        attach_inputs(&mut file, model)?;
        let mut beginning = Batch::default();
        let (channels, joints) = prepare(&mut file, &mut beginning, model)?;
        // What never changes is safe in the file before the run begins.
        file.append(&beginning)?;
        file.begin()?;
        let file = BackgroundFile::new(path, file)?;
        Ok(Recorder::new(Sink::File(file), channels, joints, model, stages))
    }

    /// Holds a run against the log at `path`, which a run of the same model made in the same way has written: the first
    /// message that differs is the error of [`Observer::sample`], a [`Difference`].
    ///
    /// # Errors
    /// [`LogError::Write`] if there can be no thread that reads the log.
    pub fn compare(path: &Path, model: &'m Model, stages: f64) -> Result<Self, LogError> {
        let mut comparison = Comparison::new(path)?;
        let (channels, joints) = prepare(&mut comparison, &mut Batch::default(), model)?;
        Ok(Recorder::new(Sink::Comparison(comparison), channels, joints, model, stages))
    }

    fn new(sink: Sink, channels: Channels, joints: JointMessages<'m>, model: &Model, stages: f64) -> Self {
        let links = drawn_links(&model.links);
        Recorder {
            transforms: TransformsEncoder::new(world_frame(&model.links), links.iter().map(|link| link.name.as_str())),
            joints,
            sink,
            channels,
            stages,
            links,
            waiting: None,
            last_figures: None,
            last_counts: Counts::default(),
            last_time: 0,
            buffer: Vec::new(),
        }
    }

    /// Adds a line to `/log` at the time of the last message.
    pub fn say(&mut self, severity: Severity, text: &str) {
        let line = log_line(self.last_time, severity, text);
        let channel = self.channels.log;
        self.sink.piece().push(channel, self.last_time, &line);
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
        self.write_figures(f64::INFINITY);
        match self.sink {
            Sink::File(file) => file.finish(ending).map(drop),
            Sink::Comparison(_) => Ok(()),
        }
    }

    /// Ends a comparison: how much was compared, and the first difference, if any.
    pub fn compared(mut self) -> (Compared, Result<(), Difference>) {
        self.write_figures(f64::INFINITY);
        match self.sink {
            Sink::File(_) => (Compared::default(), Ok(())),
            Sink::Comparison(comparison) => comparison.finish(),
        }
    }

    fn write_transforms(&mut self, sample: &Sample, stamp: u64) {
        let poses = self.links.iter().map(|link| {
            let (translation, rotation) = match link.body.map(|body| &sample.bodies[body]) {
                Some(body) => (
                    body.position + body.rotation * link.in_body.translation.vector,
                    body.rotation * link.in_body.rotation.matrix(),
                ),
                None => (link.in_body.translation.vector, *link.in_body.rotation.matrix()),
            };
            (translation.into(), wxyz_from_rotation(&rotation))
        });
        let message = self.transforms.encode(stamp, poses);
        self.sink.piece().push(self.channels.transforms, stamp, message);
    }

    /// Writes the figures of the step that is waiting, if it ended at or before `time`.
    fn write_figures(&mut self, time: f64) {
        let Some(end) = self.waiting.take_if(|end| end.time <= time) else { return };
        let messages = self.sink.piece();
        let stamp = nanoseconds(end.time);
        let (energy, exchange) = (end.energy, end.exchange);
        let energies = [energy.kinetic, energy.potential, energy.total(), exchange.dissipated, exchange.work];
        let label = "kinetic, potential, total; since the start: dissipated, work put in [J]";
        ros::encode_figures(label, &energies, &mut self.buffer);
        messages.push(self.channels.energy, stamp, &self.buffer);
        let violation = [end.violation.position, end.violation.velocity];
        ros::encode_figures("position [m, rad], velocity [m/s, rad/s]", &violation, &mut self.buffer);
        messages.push(self.channels.constraint, stamp, &self.buffer);
        // Several steps may have been made since the figures before these.
        let (counts, last) = (end.so_far, self.last_counts);
        let work = [
            end.outcome.step,
            self.stages,
            (counts.steps - last.steps) as f64,
            (counts.iterations - last.iterations) as f64,
            (counts.rejected - last.rejected) as f64,
        ];
        ros::encode_figures(
            "last step [s], stages; since before: steps, iterations, rejected steps",
            &work,
            &mut self.buffer,
        );
        messages.push(self.channels.solver, stamp, &self.buffer);
        self.last_counts = counts;
        self.last_figures = Some(end.time);
        self.last_time = self.last_time.max(stamp);
    }
}

impl Observer for Recorder<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let stamp = nanoseconds(sample.time);
        self.write_figures(sample.time);
        self.last_time = stamp;
        self.write_transforms(sample, stamp);
        self.joints.write(sample, stamp, &mut self.buffer, self.sink.piece());
        if self.last_figures != Some(sample.step.time) {
            self.waiting = Some(*sample.step);
            self.write_figures(sample.time);
        }
        match &mut self.sink {
            Sink::File(file) => Ok(file.settle()?),
            Sink::Comparison(comparison) => Ok(comparison.settle()?),
        }
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
fn prepare<'m>(
    file: &mut dyn LogChannels,
    beginning: &mut Batch,
    model: &'m Model,
) -> Result<(Channels, JointMessages<'m>), LogError> {
    let left_out = describe(file, beginning, model)?;
    let channels = Channels {
        log: foxglove_channel::<messages::Log>(file, "/log")?,
        transforms: foxglove_channel::<FrameTransforms>(file, "/tf")?,
        energy: ros_channel(file, "/energy", ros::FLOAT64_MULTI_ARRAY)?,
        constraint: ros_channel(file, "/constraint", ros::FLOAT64_MULTI_ARRAY)?,
        solver: ros_channel(file, "/solver", ros::FLOAT64_MULTI_ARRAY)?,
    };
    let joints = JointMessages::new(file, model, world_frame(&model.links))?;
    for warning in model.warnings.iter().map(ToString::to_string).chain(left_out) {
        beginning.push(channels.log, 0, &log_line(0, Severity::Warning, &warning));
    }
    Ok((channels, joints))
}

/// For viewers each robot's URDF and the looks of all of them; says what could not be put into the log. With several
/// robots all names have the robot's before them, as in the transforms.
fn describe(file: &mut dyn LogChannels, beginning: &mut Batch, model: &Model) -> Result<Vec<String>, LogError> {
    let mut buffer = Vec::new();
    let mut looks = Looks::default();
    for (index, placed) in model.robots.iter().enumerate() {
        let (prefix, robot) = (model.prefix(index), &placed.robot);
        let channel = ros_channel(file, &format!("/{prefix}robot_description"), ros::STRING)?;
        let standins = standins(model, placed);
        let description =
            if prefix.is_empty() { robot.description.clone() } else { robot.prefixed_description(&prefix) };
        ros::encode_string(
            &with_standins(&description, &prefix, &standins, &|link| robot.links[link].name.clone()),
            &mut buffer,
        );
        beginning.push(channel, 0, &buffer);
        looks.add(&robot.links, &prefix, &standins);
    }
    if !looks.scene.entities.is_empty() {
        let channel = foxglove_channel::<SceneUpdate>(file, "/scene")?;
        encode(&looks.scene, &mut buffer);
        beginning.push(channel, 0, &buffer);
    }
    Ok(looks.warnings)
}

/// The links that get a transform: all, save a link that is the world frame itself.
fn drawn_links(links: &[LinkFrame]) -> Vec<LinkFrame> {
    let is_world =
        |link: &LinkFrame| link.name == WORLD_FRAME && link.body.is_none() && link.in_body == Pose::identity();
    links.iter().filter(|link| !is_world(link)).cloned().collect()
}

/// The name of the frame of the world.
fn world_frame(links: &[LinkFrame]) -> &'static str {
    // A link may be called `world` and still move; its transform must not have itself as the parent.
    if drawn_links(links).iter().any(|link| link.name == WORLD_FRAME) { "simulation_world" } else { WORLD_FRAME }
}

fn foxglove_channel<M: Encode>(file: &mut dyn LogChannels, topic: &str) -> Result<u16, LogError> {
    // All of foxglove's own messages have a schema.
    let schema = M::get_schema().unwrap_or_else(|| Schema::new("", "", Vec::new()));
    file.channel(topic, (&schema.name, &schema.encoding, &schema.data), &M::get_message_encoding())
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

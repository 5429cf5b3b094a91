//! The observer that turns samples into messages of the log (the table of [`crate::log`]).
//!
//! Everything that does not change is prepared once: names, message layouts, buffers. The figures of a step belong to
//! its end, which lies after the samples inside the step; they wait for the first sample that is not earlier, so that
//! times never go back in the file.

use super::background::BackgroundFile;
use super::batch::Batch;
use super::file::{Ending, LogError, LogFile};
use super::joints::JointMessages;
use super::nanoseconds;
use super::ros::{self, ros_channel};
use crate::model::joint::wxyz_from_rotation;
use crate::model::{LinkFrame, Model, PlacedRobot, Pose};
use crate::simulation::{Observer, ObserverError, Sample, StepEnd};
use foxglove::messages::{self, FrameTransform, FrameTransforms, Quaternion, SceneUpdate, Timestamp, Vector3};
use foxglove::{Encode, Schema};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The frame all poses are given in, unless a moving link has taken the name.
const WORLD_FRAME: &str = "world";

/// How serious a line of `/log` is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The run goes on.
    Warning,
    /// The run ended.
    Error,
}

/// Writes a run to an MCAP file.
pub struct Recorder<'m> {
    file: BackgroundFile,
    channels: Channels,
    links: Vec<LinkFrame>,
    transforms: FrameTransforms,
    joints: JointMessages<'m>,
    waiting: Option<StepEnd>,
    last_figures: Option<f64>,
    last_time: u64,
    buffer: Vec<u8>,
}

struct Channels {
    log: u16,
    transforms: u16,
    energy: u16,
    constraint: u16,
}

impl<'m> Recorder<'m> {
    /// Creates the file at `path`, or replaces what is in it, and writes what is known before the first sample;
    /// `simulation` says how the run is made.
    ///
    /// # Errors
    /// [`LogError`] when the file cannot be created or written.
    pub fn create(path: &Path, model: &'m Model, simulation: BTreeMap<String, String>) -> Result<Self, LogError> {
        let mut file = LogFile::create(path)?;
        file.metadata("simulation", simulation)?;
        let mut beginning = Batch::default();
        describe(&mut file, &mut beginning, model)?;
        let channels = Channels {
            log: foxglove_channel::<messages::Log>(&mut file, "/log")?,
            transforms: foxglove_channel::<FrameTransforms>(&mut file, "/tf")?,
            energy: ros_channel(&mut file, "/energy", ros::FLOAT64_MULTI_ARRAY)?,
            constraint: ros_channel(&mut file, "/constraint", ros::FLOAT64_MULTI_ARRAY)?,
        };
        let joints = JointMessages::new(&mut file, model)?;
        for warning in &model.warnings {
            beginning.push(channels.log, 0, &log_line(0, Severity::Warning, &warning.to_string()));
        }
        // What never changes is safe in the file before the run begins.
        file.append(&beginning)?;
        file.begin()?;
        let links = drawn_links(&model.links);
        Ok(Recorder {
            transforms: transforms_of(&links),
            joints,
            file: BackgroundFile::new(path, file)?,
            channels,
            links,
            waiting: None,
            last_figures: None,
            last_time: 0,
            buffer: Vec::new(),
        })
    }

    /// Adds a line to `/log` at the time of the last message.
    pub fn say(&mut self, severity: Severity, text: &str) {
        let line = log_line(self.last_time, severity, text);
        self.file.piece().push(self.channels.log, self.last_time, &line);
    }

    /// Where the log is while it is written: its output, or the neighbour of an output that must not be lost yet.
    pub fn current(&self) -> &Path {
        self.file.current()
    }

    /// Whether the log is beside its output, which must stay until the run has finished.
    pub fn is_beside(&self) -> bool {
        self.file.is_beside()
    }

    /// Writes everything that is still in memory and how the run ended, and completes the file. Returns where it is: its
    /// output, or the neighbour if a run that did not finish must not replace what is there.
    ///
    /// # Errors
    /// [`LogError::Write`], also for what earlier messages could not be written for.
    pub fn finish(mut self, ending: Ending) -> Result<PathBuf, LogError> {
        self.write_figures(f64::INFINITY);
        self.file.finish(ending)
    }

    fn write_transforms(&mut self, sample: &Sample, stamp: u64) {
        for (link, transform) in self.links.iter().zip(&mut self.transforms.transforms) {
            let (translation, rotation) = match link.body.map(|body| &sample.bodies[body]) {
                Some(body) => (
                    body.position + body.rotation * link.in_body.translation.vector,
                    body.rotation * link.in_body.rotation.matrix(),
                ),
                None => (link.in_body.translation.vector, *link.in_body.rotation.matrix()),
            };
            let [w, x, y, z] = wxyz_from_rotation(&rotation);
            transform.timestamp = Some(timestamp(stamp));
            transform.translation = Some(Vector3 { x: translation.x, y: translation.y, z: translation.z });
            transform.rotation = Some(Quaternion { x, y, z, w });
        }
        encode(&self.transforms, &mut self.buffer);
        self.file.piece().push(self.channels.transforms, stamp, &self.buffer);
    }

    /// Writes the figures of the step that is waiting, if it ended at or before `time`.
    fn write_figures(&mut self, time: f64) {
        let Some(end) = self.waiting.take_if(|end| end.time <= time) else { return };
        let stamp = nanoseconds(end.time);
        let energy = [end.energy.kinetic, end.energy.potential, end.energy.total()];
        ros::encode_figures("kinetic, potential, total [J]", &energy, &mut self.buffer);
        self.file.piece().push(self.channels.energy, stamp, &self.buffer);
        let violation = [end.violation.position, end.violation.velocity];
        ros::encode_figures("position [m, rad], velocity [m/s, rad/s]", &violation, &mut self.buffer);
        self.file.piece().push(self.channels.constraint, stamp, &self.buffer);
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
        self.joints.write(sample, stamp, &mut self.buffer, self.file.piece());
        if self.last_figures != Some(sample.step.time) {
            self.waiting = Some(*sample.step);
            self.write_figures(sample.time);
        }
        Ok(self.file.settle()?)
    }
}

/// An encoded line of `/log`.
fn log_line(time: u64, severity: Severity, text: &str) -> Vec<u8> {
    let level = match severity {
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

/// What was read as attachments, and for viewers each robot's URDF and the looks of all of them. With several robots all
/// names have the robot's before them, as in the transforms.
fn describe(file: &mut LogFile, beginning: &mut Batch, model: &Model) -> Result<(), LogError> {
    let file_name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    if let Some(scene) = &model.scene {
        file.attach(&file_name(&scene.path), "application/toml", scene.text.as_bytes())?;
    }
    let mut buffer = Vec::new();
    let mut looks = SceneUpdate::default();
    for (index, PlacedRobot { robot, .. }) in model.robots.iter().enumerate() {
        let prefix = model.prefix(index);
        file.attach(&format!("{prefix}{}", file_name(&robot.path)), "application/xml", robot.source.as_bytes())?;
        let channel = ros_channel(file, &format!("/{prefix}robot_description"), ros::STRING)?;
        if prefix.is_empty() {
            ros::encode_string(&robot.description, &mut buffer);
        } else {
            ros::encode_string(&robot.prefixed_description(&prefix), &mut buffer);
        }
        beginning.push(channel, 0, &buffer);
        looks.entities.extend(super::visual::entities(&robot.links, &prefix));
    }
    if !looks.entities.is_empty() {
        let channel = foxglove_channel::<SceneUpdate>(file, "/scene")?;
        encode(&looks, &mut buffer);
        beginning.push(channel, 0, &buffer);
    }
    Ok(())
}

/// The links that get a transform: all, save a link that is the world frame itself.
fn drawn_links(links: &[LinkFrame]) -> Vec<LinkFrame> {
    let is_world =
        |link: &LinkFrame| link.name == WORLD_FRAME && link.body.is_none() && link.in_body == Pose::identity();
    links.iter().filter(|link| !is_world(link)).cloned().collect()
}

fn transforms_of(links: &[LinkFrame]) -> FrameTransforms {
    // A link may be called `world` and still move; its transform must not have itself as the parent.
    let taken = links.iter().any(|link| link.name == WORLD_FRAME);
    let parent = if taken { "simulation_world" } else { WORLD_FRAME };
    let transforms = links.iter().map(|link| FrameTransform {
        parent_frame_id: parent.to_string(),
        child_frame_id: link.name.clone(),
        ..FrameTransform::default()
    });
    FrameTransforms { transforms: transforms.collect() }
}

fn foxglove_channel<M: Encode>(file: &mut LogFile, topic: &str) -> Result<u16, LogError> {
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

//! Makes messages of samples (the table of [`crate::log`]).
//!
//! Everything that does not change is prepared once: names, message layouts, buffers. Samples are looked at several at once
//! ([`crate::snapshots`]); what is in a message does not depend on which samples its own was looked at with.

use super::file::{LogError, MessageSink};
use super::joints::JointMessages;
use super::nanoseconds;
use super::queue::{Between, Figures, Piece};
use super::ros::{self, Template, ros_channel};
use super::transforms::TransformsEncoder;
use crate::lobatto::instants::{INSTANTS, Instants, LinkPlace, Snapshots};
use crate::model::{LinkFrame, Model, Pose};
use crate::snapshots::instants;
use foxglove::messages::{self, FrameTransforms};
use foxglove::{Encode, Schema};

/// The frame all poses are given in, unless a moving link has taken the name.
const WORLD_FRAME: &str = "world";

/// Makes messages of the samples of one run.
pub(super) struct SampleEncoder {
    log: u16,
    transforms_channel: u16,
    /// Energies, violation and work.
    figures: [(u16, Template); 3],
    transforms: TransformsEncoder,
    joints: JointMessages,
    instants: Box<dyn Instants>,
    snapshots: Snapshots,
    position_count: usize,
    velocity_count: usize,
}

impl SampleEncoder {
    /// Adds the channels of a run of this model.
    pub(super) fn new(sink: &mut dyn MessageSink, model: &Model) -> Result<Self, LogError> {
        let (mechanism, links) = (&model.mechanism, drawn_links(&model.links));
        let world = world_frame(&model.links);
        let places: Vec<LinkPlace> = links.iter().map(|link| (link.body, link.in_body)).collect();
        let log = foxglove_channel::<messages::Log>(sink, "/log")?;
        let transforms_channel = foxglove_channel::<FrameTransforms>(sink, "/tf")?;
        let mut figures = |topic: &str, label: &str, count: usize| -> Result<_, LogError> {
            Ok((ros_channel(sink, topic, ros::FLOAT64_MULTI_ARRAY)?, Template::figures(label, count)))
        };
        Ok(SampleEncoder {
            log,
            transforms_channel,
            figures: [
                figures("/energy", "kinetic, potential, total; since the start: dissipated, work put in [J]", 5)?,
                figures("/constraint", "position [m, rad], velocity [m/s, rad/s]", 2)?,
                figures("/solver", "last step [s], stages; since before: steps, iterations, rejected steps", 5)?,
            ],
            transforms: TransformsEncoder::new(world, links.iter().map(|link| link.name.as_str())),
            joints: JointMessages::new(sink, model, world)?,
            instants: instants(mechanism, &places),
            snapshots: Snapshots::new(mechanism, places.len()),
            position_count: mechanism.position_count,
            velocity_count: mechanism.velocity_count,
        })
    }

    /// Adds an encoded line of `/log`.
    pub(super) fn line(&self, sink: &mut dyn MessageSink, nanoseconds: u64, line: &[u8]) -> Result<(), LogError> {
        sink.message(self.log, nanoseconds, line).map(drop)
    }

    /// Adds the messages of everything in a piece. Does not allocate.
    pub(super) fn encode(&mut self, piece: &Piece, sink: &mut dyn MessageSink) -> Result<(), LogError> {
        let mut between = piece.between.iter().peekable();
        for (group, times) in piece.times.chunks(INSTANTS).enumerate() {
            let first = group * INSTANTS;
            let positions = &piece.positions[first * self.position_count..][..times.len() * self.position_count];
            let velocities = &piece.velocities[first * self.velocity_count..][..times.len() * self.velocity_count];
            self.instants.look(positions, velocities, times.len(), &mut self.snapshots);
            for (instant, &time) in times.iter().enumerate() {
                while let Some((_, what)) = between.next_if(|(before, _)| *before <= first + instant) {
                    self.encode_between(what, sink)?;
                }
                let stamp = nanoseconds(time);
                let poses = self.snapshots.poses.iter().map(|[x, y, z, qw, qx, qy, qz]| {
                    ([x[instant], y[instant], z[instant]], [qw[instant], qx[instant], qy[instant], qz[instant]])
                });
                let message = sink.message(self.transforms_channel, stamp, self.transforms.prepare(stamp))?;
                self.transforms.fill(message, poses);
                let position = &positions[instant * self.position_count..][..self.position_count];
                let velocity = &velocities[instant * self.velocity_count..][..self.velocity_count];
                self.joints.write((position, velocity), (&self.snapshots, instant), stamp, sink)?;
            }
        }
        between.try_for_each(|(_, what)| self.encode_between(what, sink))
    }

    fn encode_between(&self, what: &Between, sink: &mut dyn MessageSink) -> Result<(), LogError> {
        let (stamp, Figures { energies, violation, work }) = match what {
            Between::Line(stamp, line) => return self.line(sink, *stamp, line),
            Between::Figures(stamp, figures) => (*stamp, figures),
        };
        for ((channel, template), numbers) in self.figures.iter().zip([&energies[..], violation, work]) {
            template.fill(sink.message(*channel, stamp, template.encoded())?, 0, numbers.iter().copied());
        }
        Ok(())
    }
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

/// Adds a channel for messages of foxglove's own.
pub(super) fn foxglove_channel<M: Encode>(sink: &mut dyn MessageSink, topic: &str) -> Result<u16, LogError> {
    // All of foxglove's own messages have a schema.
    let schema = M::get_schema().unwrap_or_else(|| Schema::new("", "", Vec::new()));
    sink.channel(topic, (&schema.name, &schema.encoding, &schema.data), &M::get_message_encoding())
}

//! The messages of `/contact_forces`: the forces of closed contacts as arrows, at every sample of a run with shapes that may touch.
//!
//! A message is a `visualization_msgs/msg/MarkerArray`. Its first marker deletes the arrows before it. Then comes an arrow for each force that
//! is not zero, from the point x of the contact to x + s f, with the force f on the first shape (N) and the scale s (m/N):
//!
//! ```text
//!     s = 0.5 m / (m g)        m the mass of everything that moves, g gravity; 0.01 m/N without gravity
//! ```
//!
//! Arrows of contacts that stick are lighter than arrows of contacts that slip.

use crate::mechanism::motion::contact_point::ContactPoint;
use crate::model::Model;
use crate::output::log::encoding::cdr::CdrWriter;
use crate::output::log::encoding::definitions::MARKER_ARRAY;
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::markers::{Head, write_arrow, write_deletion};
use crate::output::log::messages::topics::Topics;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;

/// The topic, and the namespace of its markers.
const TOPIC: &str = "/contact_forces";
const NAMESPACE: &str = "contact_forces";

/// Length of an arrow of the weight of everything (m), and of one of a newton where there is no gravity.
const WEIGHT_LENGTH: f64 = 0.5;
const NEWTON_LENGTH: f64 = 0.01;

/// Writes the arrows of samples.
pub(crate) struct ContactForces {
    channel: u16,
    world: String,
    /// Length of an arrow (m/N).
    scale: f64,
    buffer: Vec<u8>,
}

impl ContactForces {
    /// Adds the channel if it is wanted and anything of the model may touch; arrows are in the frame `world`.
    pub(crate) fn new(
        sink: &mut dyn MessageSink,
        model: &Model,
        world: &str,
        wanted: &Topics,
    ) -> Result<Option<Self>, LogError> {
        if model.mechanism.nonsmooth.pairs.is_empty() || !wanted.has(TOPIC) {
            return Ok(None);
        }
        let weight = model.mechanism.total_mass() * model.mechanism.gravity.norm();
        Ok(Some(ContactForces {
            channel: sink.channel(TOPIC, &MARKER_ARRAY, Durability::Volatile)?,
            world: world.to_string(),
            scale: if weight > 0.0 { WEIGHT_LENGTH / weight } else { NEWTON_LENGTH },
            buffer: Vec::new(),
        }))
    }

    /// Adds the message of the contacts at a sample.
    pub(crate) fn write(
        &mut self,
        stamp: u64,
        points: &[ContactPoint],
        sink: &mut dyn MessageSink,
    ) -> Result<(), LogError> {
        let pushing = || points.iter().filter(|point| point.force.norm() > 0.0);
        let mut writer = CdrWriter::begin(&mut self.buffer);
        writer.unsigned(1 + pushing().count() as u32);
        let head = |number| Head { frame: &self.world, namespace: NAMESPACE, number, nanoseconds: stamp };
        write_deletion(&head(0), &mut writer);
        for (number, point) in (1..).zip(pushing()) {
            let arrow = self.scale * point.force;
            let ends = [point.position, point.position + arrow].map(Into::into);
            let green = if point.sticks { 0.75 } else { 0.45 };
            // Forces of impacts are drawn long, and not thick.
            write_arrow(&head(number), ends, arrow.norm().min(WEIGHT_LENGTH), [1.0, green, 0.1, 1.0], &mut writer);
        }
        sink.message(self.channel, stamp, &self.buffer).map(drop)
    }
}

//! The messages of `/ropes`: every rope of the scene as a line through its points, at every sample.
//!
//! A message is a `visualization_msgs/msg/MarkerArray` of one `LINE_STRIP` for each rope, in the frame of the world. Its namespace is the name of the
//! rope. Points lie in their bodies as links do ([`crate::output::log::recording::encoder`] looks at both).

use crate::lobatto::instants::snapshot::{LinkPlace, Snapshots};
use crate::model::Model;
use crate::output::log::encoding::cdr::CdrWriter;
use crate::output::log::encoding::definitions::MARKER_ARRAY;
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::markers::{Head, write_line};
use crate::output::log::messages::topics::Topics;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;

/// The topic.
const TOPIC: &str = "/ropes";
/// Width of a line (m), and its colour: red, green, blue, opacity.
const WIDTH: f64 = 0.01;
const COLOR: [f64; 4] = [0.54, 0.42, 0.23, 1.0];

/// Writes the lines of samples.
pub(crate) struct RopeMessages {
    channel: u16,
    world: String,
    /// The name of every rope, and how many points it has.
    ropes: Vec<(String, usize)>,
    /// The number of the first point among the places that are looked at.
    first: usize,
    buffer: Vec<u8>,
}

impl RopeMessages {
    /// Adds the channel if it is wanted and there are ropes, and their points to the places that are looked at.
    pub(crate) fn new(
        sink: &mut dyn MessageSink,
        model: &Model,
        world: &str,
        wanted: &Topics,
        places: &mut Vec<LinkPlace>,
    ) -> Result<Option<Self>, LogError> {
        // Ropes are left out with contacts.
        let ropes = &model.contact.ropes;
        if ropes.is_empty() || model.mechanism.nonsmooth.pairs.is_empty() || !wanted.has(TOPIC) {
            return Ok(None);
        }
        let first = places.len();
        places.extend(ropes.iter().flat_map(|rope| rope.seen_points()).map(|point| (point.body, point.frame)));
        Ok(Some(RopeMessages {
            channel: sink.channel(TOPIC, &MARKER_ARRAY, Durability::Volatile)?,
            world: world.to_string(),
            ropes: ropes.iter().map(|rope| (rope.name.clone(), rope.seen_points().len())).collect(),
            first,
            buffer: Vec::new(),
        }))
    }

    /// Adds the message of a sample, by its number among those that were looked at. Does not allocate.
    pub(crate) fn write(
        &mut self,
        (snapshots, instant): (&Snapshots, usize),
        stamp: u64,
        sink: &mut dyn MessageSink,
    ) -> Result<(), LogError> {
        let mut writer = CdrWriter::begin(&mut self.buffer);
        writer.unsigned(self.ropes.len() as u32);
        let mut places = snapshots.poses[self.first..].iter().map(|[x, y, z, ..]| [x[instant], y[instant], z[instant]]);
        for (name, count) in &self.ropes {
            let head = Head { frame: &self.world, namespace: name, number: 0, nanoseconds: stamp };
            write_line(&head, (places.by_ref().take(*count), *count), WIDTH, COLOR, &mut writer);
        }
        sink.message(self.channel, stamp, &self.buffer).map(drop)
    }
}

//! The messages of `/events`: one for each event, when it happens.
//!
//! | field     | what                                                                            |
//! |-----------|---------------------------------------------------------------------------------|
//! | `header`  | the time in nanoseconds, as the log has it                                      |
//! | `time`    | the time in full (s), because events are located more finely than nanoseconds    |
//! | `kind`    | one of [`crate::mechanism::motion::event::EventKind`]'s names                   |
//! | `what`    | the joint, or `a\|b` of two shapes that touch                                    |
//! | `impulse` | of an impact [N m s or N s], positive into the allowed range; otherwise not a number |

use crate::mechanism::motion::event::Event;
use crate::model::Model;
use crate::output::log::encoding::cdr::CdrWriter;
use crate::output::log::encoding::definitions::{Definition, HEADER};
use crate::output::log::encoding::durability::Durability;
use crate::output::log::messages::pair_names::PairNames;
use crate::output::log::messages::topics::Topics;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;
use crate::output::report::joint_name;

/// An event, which no package of ROS defines: viewers decode it by this definition, which is in the log.
static EVENT: Definition = Definition {
    name: "catena_msgs/msg/Event",
    fields: "std_msgs/Header header\nfloat64 time\nstring kind\nstring what\nfloat64 impulse\n",
    uses: &[&HEADER],
};

/// Writes events.
pub(crate) struct EventMessages {
    channel: u16,
    /// The names of the joints by the bodies that they carry.
    names: Vec<String>,
    /// The names `a|b` of the pairs that may touch.
    pairs: PairNames,
    buffer: Vec<u8>,
}

impl EventMessages {
    /// Adds the channel if it is wanted and anything of the model can make an event.
    pub(crate) fn new(sink: &mut dyn MessageSink, model: &Model, wanted: &Topics) -> Result<Option<Self>, LogError> {
        if model.mechanism.nonsmooth.is_empty() || !wanted.has("/events") {
            return Ok(None);
        }
        Ok(Some(EventMessages {
            channel: sink.channel("/events", &EVENT, Durability::Volatile)?,
            names: (0..model.mechanism.bodies.len()).map(|body| joint_name(model, body).to_string()).collect(),
            pairs: PairNames::new(model),
            buffer: Vec::new(),
        }))
    }

    /// Adds the message of an event.
    pub(crate) fn write(&mut self, stamp: u64, event: &Event, sink: &mut dyn MessageSink) -> Result<(), LogError> {
        let mut writer = CdrWriter::begin(&mut self.buffer);
        writer.time(stamp);
        writer.string("");
        writer.double(event.time);
        writer.string(event.kind.name());
        match event.pair {
            Some(number) => writer.string(&self.pairs.of(number).join("|")),
            None => writer.string(self.names.get(event.body).map_or("", String::as_str)),
        }
        writer.double(event.impulse.unwrap_or(f64::NAN));
        sink.message(self.channel, stamp, &self.buffer).map(drop)
    }
}

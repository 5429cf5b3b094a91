//! The messages of `/events`: one for each event, when it happens.
//!
//! | field     | what                                                                            |
//! |-----------|---------------------------------------------------------------------------------|
//! | `header`  | the time in nanoseconds, as the log has it                                      |
//! | `time`    | the time in full (s), because events are located more finely than nanoseconds    |
//! | `kind`    | one of [`crate::mechanism::motion::event::EventKind`]'s names                   |
//! | `what`    | the joint                                                                       |
//! | `impulse` | of an impact [N m s or N s], positive into the allowed range; otherwise not a number |

use crate::mechanism::motion::event::Event;
use crate::model::Model;
use crate::output::log::cdr::CdrWriter;
use crate::output::log::error::LogError;
use crate::output::log::file::MessageSink;
use crate::output::log::ros;
use crate::output::log::ros::ros_channel;
use crate::output::report::joint_name;

/// Writes events.
pub(crate) struct EventMessages {
    channel: u16,
    /// The names of the joints by the bodies that they carry.
    names: Vec<String>,
    buffer: Vec<u8>,
}

impl EventMessages {
    /// Adds the channel if anything of the model can make an event.
    pub(crate) fn new(sink: &mut dyn MessageSink, model: &Model) -> Result<Option<Self>, LogError> {
        if model.mechanism.nonsmooth.is_empty() {
            return Ok(None);
        }
        Ok(Some(EventMessages {
            channel: ros_channel(sink, "/events", ros::EVENT)?,
            names: (0..model.mechanism.bodies.len()).map(|body| joint_name(model, body).to_string()).collect(),
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
        writer.string(self.names.get(event.body).map_or("", String::as_str));
        writer.double(event.impulse.unwrap_or(f64::NAN));
        sink.message(self.channel, stamp, &self.buffer).map(drop)
    }
}

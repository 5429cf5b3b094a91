//! The messages of `/contacts`: the closed contacts at every sample of a run with shapes that may touch.
//!
//! | field      | what                                                                  |
//! |------------|-----------------------------------------------------------------------|
//! | `a`, `b`   | the names of the link and of the obstacle or other link               |
//! | `position` | where they touch, in the world (m)                                    |
//! | `normal`   | of length one, from b to a                                            |
//! | `force`    | on a (N)                                                              |
//! | `gap`      | negative where they overlap (m)                                       |
//! | `state`    | `stick` or `slip`                                                     |

use crate::mechanism::motion::contact_point::ContactPoint;
use crate::model::Model;
use crate::output::log::encoding::cdr::CdrWriter;
use crate::output::log::encoding::definitions::{Definition, HEADER, POINT, VECTOR};
use crate::output::log::encoding::durability::Durability;
use crate::output::log::messages::pair_names::PairNames;
use crate::output::log::messages::topics::Topics;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;
use crate::output::report::state_name;

static CONTACT: Definition = Definition {
    name: "catena_msgs/msg/Contact",
    fields: "string a\nstring b\ngeometry_msgs/Point position\ngeometry_msgs/Vector3 normal\ngeometry_msgs/Vector3 force\n\
             float64 gap\nstring state\n",
    uses: &[&POINT, &VECTOR],
};

/// The contacts of an instant, which no package of ROS defines: viewers decode them by this definition, which is in the log.
static CONTACTS: Definition = Definition {
    name: "catena_msgs/msg/Contacts",
    fields: "std_msgs/Header header\ncatena_msgs/Contact[] contacts\n",
    uses: &[&HEADER, &CONTACT],
};

/// Writes the contacts of samples.
pub(crate) struct ContactMessages {
    channel: u16,
    world: String,
    names: PairNames,
    buffer: Vec<u8>,
}

impl ContactMessages {
    /// Adds the channel if it is wanted and anything of the model may touch; positions are in the frame `world`.
    pub(crate) fn new(
        sink: &mut dyn MessageSink,
        model: &Model,
        world: &str,
        wanted: &Topics,
    ) -> Result<Option<Self>, LogError> {
        if model.mechanism.nonsmooth.pairs.is_empty() || !wanted.has("/contacts") {
            return Ok(None);
        }
        Ok(Some(ContactMessages {
            channel: sink.channel("/contacts", &CONTACTS, Durability::Volatile)?,
            world: world.to_string(),
            names: PairNames::new(model),
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
        let mut writer = CdrWriter::begin(&mut self.buffer);
        writer.time(stamp);
        writer.string(&self.world);
        writer.unsigned(points.len() as u32);
        for point in points {
            let [a, b] = self.names.of(point.pair);
            writer.string(a);
            writer.string(b);
            for number in [&point.position, &point.normal, &point.force].into_iter().flatten() {
                writer.double(*number);
            }
            writer.double(point.gap);
            writer.string(state_name(point));
        }
        sink.message(self.channel, stamp, &self.buffer).map(drop)
    }
}

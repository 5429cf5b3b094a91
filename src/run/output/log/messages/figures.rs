//! The messages of `/energy`, `/constraint` and `/solver`: the figures at the end of a step, every one with its name.
//!
//! | topic         | fields                                                                                              |
//! |---------------|-----------------------------------------------------------------------------------------------------|
//! | `/energy`     | `kinetic`, `potential`, `total`; since the start `dissipated` by dampers, `work` put in, lost to `friction`, in `impacts` (J) |
//! | `/constraint` | largest constraint errors: `position` (m, rad), `velocity` (m/s, rad/s)                              |
//! | `/solver`     | last `step` (s), `stages`; since the message before `steps`, `iterations`, `rejected` steps          |
//!
//! A step whose end has events has them twice: a nanosecond before its end as before its impacts, and at its end.
//!
//! No package of ROS defines these messages. The schema is in the log, so that viewers call the curves `energy.kinetic` and so on.

use crate::output::log::encoding::definitions::{Definition, HEADER};
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::template::Template;
use crate::output::log::messages::topics::Topics;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;

static ENERGY: Definition = Definition {
    name: "catena_msgs/msg/Energy",
    fields: "std_msgs/Header header\nfloat64 kinetic\nfloat64 potential\nfloat64 total\nfloat64 dissipated\nfloat64 work\n\
             float64 friction\nfloat64 impacts\n",
    uses: &[&HEADER],
};

static CONSTRAINT: Definition = Definition {
    name: "catena_msgs/msg/Constraint",
    fields: "std_msgs/Header header\nfloat64 position\nfloat64 velocity\n",
    uses: &[&HEADER],
};

static SOLVER: Definition = Definition {
    name: "catena_msgs/msg/Solver",
    fields: "std_msgs/Header header\nfloat64 step\nfloat64 stages\nfloat64 steps\nfloat64 iterations\nfloat64 rejected\n",
    uses: &[&HEADER],
};

/// The numbers of `/energy`, `/constraint` and `/solver`.
pub(crate) struct Figures {
    /// Kinetic, potential and total; since the start dissipated, put in, lost to dry friction and in impacts. A smooth run has no
    /// friction and no impacts and does not log them.
    pub energies: [f64; 7],
    pub violation: [f64; 2],
    pub work: [f64; 5],
}

/// Writes the figures of steps.
pub(crate) struct FigureMessages {
    /// Channels and layouts of energies, constraint errors and work; `None` of a topic that is not wanted.
    topics: [Option<(u16, Template)>; 3],
}

impl FigureMessages {
    /// Adds the channels.
    pub(crate) fn new(sink: &mut dyn MessageSink, wanted: &Topics) -> Result<Self, LogError> {
        let mut topic = |topic: &str, definition: &Definition, count: usize| -> Result<_, LogError> {
            if !wanted.has(topic) {
                return Ok(None);
            }
            let channel = sink.channel(topic, definition, Durability::Volatile)?;
            Ok(Some((channel, Template::numbers(count))))
        };
        Ok(FigureMessages {
            topics: [
                topic("/energy", &ENERGY, 7)?,
                topic("/constraint", &CONSTRAINT, 2)?,
                topic("/solver", &SOLVER, 5)?,
            ],
        })
    }

    /// Adds the messages of a step.
    pub(crate) fn write(
        &self,
        Figures { energies, violation, work }: &Figures,
        stamp: u64,
        sink: &mut dyn MessageSink,
    ) -> Result<(), LogError> {
        for (topic, numbers) in self.topics.iter().zip([&energies[..], violation, work]) {
            let Some((channel, template)) = topic else { continue };
            let message = sink.message(*channel, stamp, template.encoded())?;
            template.fill_stamp(message, stamp);
            template.fill(message, 0, numbers.iter().copied());
        }
        Ok(())
    }
}

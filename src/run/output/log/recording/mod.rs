//! The observer that writes a log: a queue from the run to a thread that encodes samples, figures and events in their order.

pub(crate) mod accuracy_lines;
pub(crate) mod background;
pub(crate) mod comparison;
pub(crate) mod encoder;
pub(crate) mod order;
pub(crate) mod queue;
pub(crate) mod recorder;

//! The messages of ROS 2 as bytes, and the words that all topics share.

pub(crate) mod cdr;
pub(crate) mod cdr_reader;
pub(crate) mod definitions;
pub(crate) mod durability;
pub(crate) mod ending;
pub(crate) mod line;
pub(crate) mod markers;
pub(crate) mod markers_reader;
pub(crate) mod names;
pub(crate) mod severity;
pub(crate) mod template;
pub(crate) mod time;

//! The MCAP file under a log: chunks, how they are packed, the container, and the place on disk, which is readable at every moment.

pub(crate) mod batch;
pub(crate) mod compression;
pub(crate) mod container;
pub(crate) mod error;
pub(crate) mod file;
pub(crate) mod inputs;
pub(crate) mod output;
pub(crate) mod place;
pub(crate) mod repetition;
pub(crate) mod spool;

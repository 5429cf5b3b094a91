//! The output on the terminal, and the interruption of runs.

pub(crate) mod printing;
pub(crate) mod progress;
pub(crate) mod signals;

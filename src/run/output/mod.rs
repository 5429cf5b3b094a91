//! The output of a run: log and report; and reading logs.

#[cfg(feature = "log")]
#[doc(hidden)]
pub mod inspection;
#[cfg(feature = "log")]
pub mod log;
#[cfg(not(feature = "log"))]
#[path = "no_log.rs"]
pub mod log;
pub mod report;

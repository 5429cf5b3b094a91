//! The output of a run: log, report and pages; and reading logs.

#[cfg(feature = "log")]
#[doc(hidden)]
pub mod inspection;
#[cfg(feature = "log")]
pub mod log;
#[cfg(not(feature = "log"))]
#[path = "no_log.rs"]
pub mod log;
#[cfg(feature = "log")]
pub mod page;
pub mod report;

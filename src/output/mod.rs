//! What is left of a run: the log, the report, pages, and looks at logs.

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

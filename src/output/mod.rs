//! The output of a run: log, report, pages and films; and reading logs.

#[cfg(feature = "film")]
pub mod film;
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

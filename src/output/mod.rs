//! The output of a run: log, report and pages; and reading logs.

#[doc(hidden)]
pub mod inspection;
pub mod log;
pub mod page;
pub mod report;

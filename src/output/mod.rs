//! What is left of a run: the log, the report, and looks at logs.

#[doc(hidden)]
pub mod inspection;
pub mod log;
pub mod report;

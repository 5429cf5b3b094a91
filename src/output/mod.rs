//! What is left of a run: the log, the report, pages, and looks at logs.

#[doc(hidden)]
pub mod inspection;
pub mod log;
pub mod page;
pub mod report;

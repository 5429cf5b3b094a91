//! How serious a line of a log is.

/// How serious a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Something to know.
    Info,
    /// The run goes on.
    Warning,
    /// The run ended.
    Error,
}

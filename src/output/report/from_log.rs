//! The start of a run that goes on from a log: an estimate of its error that the estimate of the run does not have.
//!
//! ```text
//!     error at the end  ≈  error of the run, from this start on  +  error of the start × its amplification
//! ```
//!
//! The amplification is not known. The error of the start is the estimated error of the log's run (m), added to that of its own start if that was in
//! a log, too.

use serde::Serialize;

/// The log entry that has the error of the start (m), or [`UNKNOWN`].
pub const ERROR_AT_START: &str = "estimated_error_at_start";
/// The value of [`ERROR_AT_START`] if it is not known.
pub const UNKNOWN: &str = "unknown";

/// A start in a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FromLog {
    /// The log.
    pub log: String,
    /// The time of the sample in it (s).
    pub time: f64,
    /// The error that is expected of the positions in it (m); null if the log does not say it.
    pub estimated_error: Option<f64>,
}

impl FromLog {
    /// The value of [`ERROR_AT_START`].
    pub(crate) fn entry(&self) -> String {
        self.estimated_error.map_or(UNKNOWN.to_string(), |error| error.to_string())
    }

    /// The line for people.
    pub(crate) fn words(&self) -> String {
        match self.estimated_error {
            Some(error) => format!(
                "t = {} s of {}, with an estimated error of {error:.1e} m, which the accuracy below does not include",
                self.time, self.log
            ),
            None => format!(
                "t = {} s of {}, which does not say its error: the accuracy below does not include it",
                self.time, self.log
            ),
        }
    }
}

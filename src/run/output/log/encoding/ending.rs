//! How a run ended, as logs tell it.

use std::collections::BTreeMap;

/// [`Outcome::Finished`] in a log.
pub const FINISHED: &str = "finished";

/// How a run ended, for the last record of its log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ending {
    /// The way it ended.
    pub outcome: Outcome,
    /// Figures of the whole run, by name.
    pub figures: BTreeMap<String, String>,
}

/// The ways a run ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// It reached its end.
    #[default]
    Finished,
    /// The user ended it.
    Interrupted,
    /// It could not go on.
    Failed,
}

impl Outcome {
    /// The word in the log.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Finished => FINISHED,
            Outcome::Interrupted => "interrupted",
            Outcome::Failed => "failed",
        }
    }
}

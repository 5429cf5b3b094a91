//! Attempts at steps that were thrown away, by reason.

use crate::mechanism::motion::integrator::{Rejected, Rejections};
use serde::{Serialize, Serializer};

/// An object with a number for each reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RejectedReport(pub Rejections);

impl Serialize for RejectedReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(Rejected::ALL.into_iter().map(|why| (why.key(), self.0.of(why))))
    }
}

impl RejectedReport {
    /// The reasons for people, after the number of all: ` (4 not converged, 2 not smooth enough)`, or empty.
    pub fn words(&self) -> String {
        let reasons: Vec<String> = self.0.reasons().map(|(why, count)| format!("{count} {}", why.words())).collect();
        if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join(", ")) }
    }
}

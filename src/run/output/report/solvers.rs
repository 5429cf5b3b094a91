//! How often each contact solver has solved a problem of an event.

use crate::mechanism::ground::words::counted;
use crate::mechanism::motion::contact_solvers::{ContactSolver, ContactSolvers};
use serde::{Serialize, Serializer};

/// An object with a number for each solver that has solved a problem, and for the problems without an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolversReport(pub ContactSolvers);

impl Serialize for SolversReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.used().map(|(by, count)| (by.key(), count)))
    }
}

impl SolversReport {
    /// Words for people, if the first two solvers were not enough: `12 problems at events: 11 cold, 1 soft`.
    pub fn words(&self) -> Option<String> {
        let usual = [ContactSolver::Warm, ContactSolver::Cold].map(|by| self.0.of(by)).iter().sum::<usize>();
        let all = self.0.total();
        let by: Vec<String> = self.0.used().map(|(by, count)| format!("{count} {}", by.key())).collect();
        (all > usual).then(|| format!("{} at events: {}", counted(all, "problem", "problems"), by.join(", ")))
    }
}

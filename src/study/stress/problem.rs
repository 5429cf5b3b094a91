//! A problem: mechanisms that become harder along one axis, and steps that become shorter along the other.

use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::motion::state::State;

/// Rough work after which a run of most cases is too slow (s).
pub const BUDGET: f64 = 0.2;

/// A family of cases of growing difficulty.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Its name, which is also the name of its files.
    pub name: &'static str,
    /// Headline.
    pub title: &'static str,
    /// The scene, in a sentence or two.
    pub scene: &'static str,
    /// The meaning of the difficulty, with its unit.
    pub axis: &'static str,
    /// The difficulties as they are written, easy ones first.
    pub difficulties: Vec<&'static str>,
    /// Steps of the methods with fixed steps (s), long ones first.
    pub steps: Vec<f64>,
    /// Builds the case of a difficulty, given by its place.
    pub build: fn(usize) -> Result<Case, MechanismError>,
}

/// The simulation of one row of a map.
#[derive(Clone, Debug)]
pub struct Case {
    /// The bodies and joints.
    pub mechanism: Mechanism,
    /// Its initial state; loops need not be closed.
    pub start: State,
    /// How long it runs (s).
    pub duration: f64,
    /// The source of the right answer.
    pub truth: Truth,
    /// How many of the last bodies are compared with the answer.
    pub watched: usize,
    /// Rough work after which a run is too slow (s); the same steps on every machine.
    pub budget: f64,
}

/// The source of the right answer of a case.
#[derive(Clone, Debug)]
pub enum Truth {
    /// The motion itself, computed with two steps that agree.
    Converged,
    /// The motion repeats itself with this period (s), so its end is the end of a short run.
    Periodic(f64),
    /// The same motion of the watched bodies in a mechanism without the difficulty.
    Same(Box<(Mechanism, State)>),
    /// There is no right answer, for this reason: a method that comes to an end has invented it.
    None(&'static str),
}

impl Case {
    /// A case whose answer is its own converged motion, and all of whose bodies are looked at.
    pub fn new(mechanism: Mechanism, start: State, duration: f64) -> Self {
        let watched = mechanism.bodies.len();
        Case { mechanism, start, duration, truth: Truth::Converged, watched, budget: BUDGET }
    }
}

impl Problem {
    /// The problem with fewer rows and columns: every `rows`-th difficulty from the easiest, and so on.
    #[must_use]
    pub fn thinned(mut self, rows: usize, columns: usize) -> ThinnedProblem {
        let places = (0..self.difficulties.len()).step_by(rows.max(1)).collect();
        self.steps = self.steps.into_iter().step_by(columns.max(1)).collect();
        ThinnedProblem { problem: self, places }
    }
}

/// A problem, and which of its difficulties are mapped.
#[derive(Clone, Debug)]
pub struct ThinnedProblem {
    /// The problem; its steps are those that are mapped.
    pub problem: Problem,
    /// Places of the difficulties that are mapped.
    pub places: Vec<usize>,
}

/// `count` steps (s) from `longest` to `shortest`, equally spaced on a logarithmic scale.
pub fn steps(longest: f64, shortest: f64, count: usize) -> Vec<f64> {
    let ratio = (shortest / longest).ln();
    (0..count).map(|rung| longest * (ratio * rung as f64 / (count - 1).max(1) as f64).exp()).collect()
}

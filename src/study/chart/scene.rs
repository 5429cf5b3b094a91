//! The scene of a chart.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;

/// What is simulated.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its name, which is also that of its files.
    pub name: String,
    /// The bodies and joints.
    pub mechanism: Mechanism,
    /// Where it starts.
    pub start: State,
    /// How long it runs (s).
    pub duration: f64,
}

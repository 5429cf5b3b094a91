//! The scene of a chart.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;

/// A simulated scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its name, which is also the name of its files.
    pub name: String,
    /// The bodies and joints.
    pub mechanism: Mechanism,
    /// Its initial state.
    pub start: State,
    /// How long it runs (s).
    pub duration: f64,
}

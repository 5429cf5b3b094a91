//! A run between two steps as a value ([`Simulation::state`](crate::session::Simulation::state)).

use crate::mechanism::motion::state::State as Motion;
use crate::session::model::Model;
use crate::simulation::Checkpoint;

/// A run between two steps, as a value: time, positions, velocities, efforts, targets of motors, and all that the steps remember (modes of joints and
/// contacts, impacts, anchors of friction, guesses and lengths of steps). A run goes on from it bit for bit.
#[derive(Clone)]
pub struct State {
    pub(crate) model: Model,
    pub(crate) kept: Checkpoint,
    /// When the controller is asked next, by the number of its calls.
    pub(crate) asked: Option<(f64, u64)>,
}

impl State {
    /// Time (s).
    pub fn time(&self) -> f64 {
        self.motion().time
    }

    /// q and v ([`Coordinates`](crate::session::Coordinates)).
    pub fn coordinates(&self) -> (Vec<f64>, Vec<f64>) {
        self.model.flat(self.motion())
    }

    fn motion(&self) -> &Motion {
        self.kept.state()
    }
}

impl std::fmt::Debug for State {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = &self.model.description().mechanism.name;
        write!(out, "State of {name:?} at t = {} s", self.time())
    }
}

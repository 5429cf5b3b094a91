//! A run between two steps as a value ([`Simulation::state`](crate::session::Simulation::state)).

use crate::mechanism::motion::state::State as Motion;
use crate::session::model::Model;
use crate::simulation::Checkpoint;

/// A run between two steps, as a value: time, positions, velocities, efforts, targets of motors, efforts that sampled motors hold, and all that the
/// steps remember (modes of joints and contacts, impacts, anchors of friction, guesses and lengths of steps). A run goes on from it bit for bit.
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

    /// The efforts that sampled motors hold until their next ticks [N m or N]: an entry a motor, in the order of [`Model::motor_names`], `None` for
    /// continuous ones. [`Simulation::hold_efforts`](crate::session::Simulation::hold_efforts) takes them.
    pub fn held_efforts(&self) -> &[Option<f64>] {
        self.kept.held_efforts()
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

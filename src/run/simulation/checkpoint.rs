//! A copy of a run between two steps: the run goes on from it to the same bits, as often as is wanted.
//!
//! ```text
//!     run ──step──▶ checkpoint c ──step──▶ x            restore(c) ──step──▶ x, bit for bit
//!                   fresh f, before the first step      place(f, state) ──step──▶ as a new run from this state
//! ```
//!
//! It holds the state, the efforts, and the integrators with all they remember: guesses, lengths of steps, modes, impacts, anchors of friction.
//! Constant parts are shared. The figures and samples of a run begin anew where it is restored.

use crate::mechanism::motion::state::State;
use crate::simulation::integrators::Integrators;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::parallel::islands::KeptIsland;
use crate::simulation::parallel::partition::Plan;
use crate::simulation::run::Simulation;

/// A copy of a run between two steps.
#[derive(Clone)]
pub struct Checkpoint {
    state: State,
    efforts: Vec<f64>,
    held: Vec<Option<f64>>,
    integrators: Kept,
}

#[derive(Clone)]
enum Kept {
    Whole(RunIntegrator),
    Islands(Vec<KeptIsland>),
}

impl Checkpoint {
    /// The state there.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The efforts that act there: one entry per degree of freedom [N m or N], or empty.
    pub fn efforts(&self) -> &[f64] {
        &self.efforts
    }

    /// The efforts that sampled motors hold there until their next ticks [N m or N]: an entry a motor.
    pub fn held_efforts(&self) -> &[Option<f64>] {
        &self.held
    }
}

impl Simulation<'_> {
    /// A copy of the run where it is; `None` for a run that estimates its own error, which has a second motion beside it.
    pub fn checkpoint(&self) -> Option<Checkpoint> {
        let integrators = match &self.integrators {
            Integrators::Whole(run) => Kept::Whole(run.alone()?.clone()),
            Integrators::Islands { islands, .. } => Kept::Islands(islands.keep()?),
        };
        let held = self.held_efforts();
        Some(Checkpoint { state: self.state.clone(), efforts: self.efforts.clone(), held, integrators })
    }

    /// Goes on from a copy of this run, or of another one of the same mechanism and settings; `false` if it is of another kind: the run is unchanged
    /// then.
    pub fn restore(&mut self, kept: &Checkpoint) -> bool {
        let restored = match (&mut self.integrators, &kept.integrators) {
            (Integrators::Whole(run), Kept::Whole(alone)) => {
                *run = alone.clone().into();
                true
            }
            (Integrators::Islands { islands, .. }, Kept::Islands(parts)) => islands.restore(parts),
            _ => false,
        };
        if restored {
            self.begin_at(&kept.state);
            self.efforts.clone_from(&kept.efforts);
        }
        restored
    }

    /// Goes on from another state, as a new run would from there; `fresh` is a copy from before the first step. The run stays
    /// as it is, and the answer is `false`, if a new run would have other integrators: with closed loops, and if parts of the mechanism rest.
    pub fn place(&mut self, fresh: &Checkpoint, state: &State) -> bool {
        let (Integrators::Whole(run), Kept::Whole(alone)) = (&mut self.integrators, &fresh.integrators) else {
            return false;
        };
        if self.mechanism.has_closures() || !Plan::new(&self.mechanism, state, &self.switched_off).is_whole() {
            return false;
        }
        *run = alone.clone().into();
        self.begin_at(state);
        self.efforts.clone_from(&fresh.efforts);
        self.known_start.place();
        true
    }

    /// A run of the same duration begins in this state.
    fn begin_at(&mut self, state: &State) {
        self.state.copy_from(state);
        self.progress = None;
        self.known_start.forget();
        self.start = None;
        self.end = state.time + self.duration;
    }
}

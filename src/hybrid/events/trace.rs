//! The trace of a run: its steps, and the jumps between them, for derivatives.
//!
//! ```text
//!     step:  x₀, mode, held joints ─▶ x̄, functions that are zero there         jump:  x⁻, limits and contacts that meet ─▶ x⁺
//! ```
//!
//! A run without a trace keeps none of this.

use crate::events::integrator::Eventful;
use crate::events::modes::piece::Piece;
use crate::events::next_step::Ending;
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Integrator, StepError};
use crate::mechanism::motion::state::State;
use crate::stepping::integrator::MethodError;
use crate::stepping::recipe::{Recipe, Steps};

pub use crate::events::effects::impact::Meeting;
pub use crate::events::finding::watched::Watched;
pub use crate::events::modes::mode::{Closed, JointMode, Mode, MotorMode};
use crate::events::parts::traced::Trace;
pub use crate::events::parts::traced::{Traced, TracedJump, TracedStep};

/// A run from instant to instant that keeps its trace.
pub struct TracedRun {
    eventful: Eventful,
    mechanism: Mechanism,
}

/// A run has no trace.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    #[error(transparent)]
    Method(#[from] MethodError),
    #[error(transparent)]
    Step(#[from] StepError),
    /// No step of the scheme was made here.
    #[error("no step of the scheme was made at t = {time} s")]
    FirstOrder { time: f64 },
}

impl TracedRun {
    /// With this number of stages; no step is longer than `longest` (s).
    ///
    /// # Errors
    /// [`MethodError`] for stages that cannot be.
    pub fn new(mechanism: &Mechanism, stages: usize, longest: f64) -> Result<Self, MethodError> {
        let recipe = Recipe::new(Steps::Fixed { stages, step: longest }, Vec::new());
        let mut eventful = Eventful::new(mechanism, recipe)?;
        let nodes = &Tableau::of(stages)?.nodes;
        eventful.trace = Some(Trace { entries: Vec::new(), nodes: &nodes[1..stages - 1] });
        Ok(TracedRun { eventful, mechanism: mechanism.clone() })
    }

    /// Makes a step towards an instant (s), and returns its trace.
    ///
    /// # Errors
    /// [`TraceError`] where a step cannot be made, or is one of first order.
    pub fn step(&mut self, state: &mut State, until: f64) -> Result<Vec<Traced>, TraceError> {
        let since = state.time;
        self.eventful.step(&self.mechanism, Inputs::NONE, state, until)?;
        let trace = self.eventful.trace.as_mut().map(|trace| std::mem::take(&mut trace.entries)).unwrap_or_default();
        let is_step = |entry: &Traced| matches!(entry, Traced::Step(_));
        if state.time > since && !trace.iter().any(is_step) {
            return Err(TraceError::FirstOrder { time: since });
        }
        Ok(trace)
    }
}

impl Eventful {
    /// Keeps a step in the trace, if there is one; `state` is its end before the events there.
    pub(super) fn trace_step(&mut self, state: &State, ending: &Ending) {
        let Some(trace) = self.trace.as_mut().filter(|_| !ending.is_at_start()) else { return };
        let since = self.trial.origin.time;
        let (step, of_scheme) = (state.time - since, ending.is_of_scheme());
        let Piece { key, .. } = self.workspaces.active();
        let mut entry = TracedStep {
            start: self.trial.origin.clone(),
            end: state.clone(),
            mode: self.mode.clone(),
            inside: Vec::new(),
            held: key.held.clone(),
            closures: key.closures.clone(),
            triggers: ending.triggers().to_vec(),
        };
        let piece = self.workspaces.active_mut();
        for node in trace.nodes.iter().filter(|_| of_scheme) {
            let mut inside = self.trial.origin.clone();
            piece.place(&self.model.whole, since + node * step, true, &mut inside);
            entry.inside.push(inside);
        }
        trace.entries.push(Traced::Step(Box::new(entry)));
    }
}

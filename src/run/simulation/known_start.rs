//! A start that a run has begun from before: its next run from there needs no decisions about contacts, no ranks and no new workspaces.
//!
//! ```text
//!     place(f, x), step     x: begin ─▶ step                         x has not been met before
//!     place(f, x), step     x: begin ─▶ kept: c ─▶ step              the second time
//!     place(f, x), step     x: c ─▶ step, bit for bit                 from then on
//! ```
//!
//! Here x are the state and the efforts from outside, and c is a copy of the integrator that has begun from them. A run that begins elsewhere each
//! time pays for a comparison alone. The last start that was met twice is kept.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::estimated_run::EstimatedRun;

/// The start of the last run, and the integrator that has begun from one.
#[derive(Default)]
pub(crate) struct KnownStart {
    /// Whether the next step is the first of a run that was placed.
    first: bool,
    last: Option<Given>,
    begun: Option<Begun>,
}

/// A start: the state, and the efforts from outside [N m or N].
struct Given {
    state: State,
    efforts: Vec<f64>,
}

/// The integrator after it has begun from a start, and the state that it goes on from.
struct Begun {
    given: Given,
    integrator: RunIntegrator,
    state: State,
}

impl Given {
    /// Whether it is this start, to the last bit.
    fn is(&self, state: &State, efforts: &[f64]) -> bool {
        let alike = |one: &[f64], other: &[f64]| one.iter().map(|x| x.to_bits()).eq(other.iter().map(|x| x.to_bits()));
        let own = &self.state;
        own.time.to_bits() == state.time.to_bits()
            && alike(&own.position, &state.position)
            && alike(&own.velocity, &state.velocity)
            && alike(&own.compensation, &state.compensation)
            && alike(&self.efforts, efforts)
    }
}

impl KnownStart {
    /// The run was placed elsewhere: its next step is the first one.
    pub fn place(&mut self) {
        self.first = true;
    }

    /// The run is not as it was placed: what follows depends on more than the state and the efforts.
    pub fn forget(&mut self) {
        self.first = false;
    }

    /// Begins the run from its start, if its next step is the first one.
    pub fn begin(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &mut State, run: &mut EstimatedRun) {
        if !std::mem::take(&mut self.first) || inputs.feedback.is_some() {
            return;
        }
        let Some(integrator) = run.alone_mut() else { return };
        if let Some(begun) = self.begun.as_ref().filter(|begun| begun.given.is(state, inputs.efforts)) {
            integrator.clone_from(&begun.integrator);
            state.copy_from(&begun.state);
            return;
        }
        let given = Given { state: state.clone(), efforts: inputs.efforts.to_vec() };
        if self.last.as_ref().is_some_and(|last| last.is(state, inputs.efforts))
            && integrator.begin(mechanism, inputs, state)
        {
            self.begun = Some(Begun { given, integrator: integrator.clone(), state: state.clone() });
        } else {
            self.last = Some(given);
        }
    }
}

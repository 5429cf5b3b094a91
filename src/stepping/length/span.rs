//! One step of a given length, as long as a span between two instants ([`crate::spans`]): it is accepted at once, or refused.
//!
//! ```text
//!     τ = until − t:   accepted if the stages converge, E r^s ≤ E_limit, and the energy and the limit of stability allow it
//! ```
//!
//! E is the top Legendre coefficient of the step, s the number of stages, and r the factor by which a longer step must be possible, too. The limits are
//! those of [`crate::length::control`].

use crate::length::control::{Control, Decision};
use crate::length::stepper::{Stepper, refusal};
use catena_lobatto::stages::attempt::Attempt;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Cost, Rejected, StepOutcome};
use catena_mechanism::motion::state::State;

/// How a span may begin a motion.
#[derive(Clone, Copy)]
pub(crate) struct Beginning {
    /// Whether a first look at stability is where it begins.
    pub ahead: bool,
    /// A step that is longer by this factor must be possible, too.
    pub room: f64,
}

impl Control {
    /// Makes one step exactly to `until` (s), if it is accepted at once, and one that is longer by a factor would keep to the limit of E, too: E grows with
    /// the power of its degree.
    ///
    /// # Errors
    /// The cost of a refused attempt: nothing without an attempt.
    pub(crate) fn span(
        &mut self,
        stepper: &mut Stepper,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
        begins: Beginning,
    ) -> Result<StepOutcome, Cost> {
        let length = until - state.time;
        if length > stepper.watch.safe_step() || mechanism.resolved_step(state.time, length, until) < length {
            return Err(Cost::default());
        }
        self.memory.step = length;
        let guess = stepper.first_guess();
        let rule = self.beside_dampers(self.bounded_rule(), stepper.decay(mechanism), length);
        let attempt = stepper.attempt(mechanism, inputs, state, length, &rule, guess);
        let Attempt::Converged { exact, legendre, .. } = attempt else {
            self.forget();
            let mut cost = Cost::of(attempt.iterations());
            cost.reject(refusal(&attempt));
            return Err(cost);
        };
        if begins.room > 1.0 && legendre * begins.room.powi(self.stages as i32) > self.limit {
            self.forget();
            let mut cost = Cost::of(attempt.iterations());
            cost.reject(Rejected::NotSmooth);
            return Err(cost);
        }
        if begins.ahead {
            stepper.look_ahead(mechanism, state);
        }
        let energies = stepper.finish(mechanism, state);
        let mut outcome = StepOutcome { cost: Cost::of(attempt.iterations()), exact, ..StepOutcome::default() };
        let refused = match self.judge(&attempt, Some(energies), length, guess) {
            Decision::Retry { why, .. } => Some(why),
            Decision::Accept if stepper.too_long_for_stability(mechanism, length).is_some() => {
                Some(Rejected::NotSmooth)
            }
            Decision::Accept => {
                let accepted = stepper.keep(mechanism, state, length, until, &mut outcome);
                outcome.exchange.dissipated -= self.memory.ringing;
                accepted.is_err().then_some(Rejected::NotConverged)
            }
        };
        if let Some(why) = refused {
            self.forget();
            outcome.cost.reject(why);
            return Err(outcome.cost);
        }
        self.look_inside(stepper, mechanism, legendre);
        Ok(outcome)
    }
}

//! Steps of varying length for very long runs: chosen so that the run retraces itself when time is turned round.
//!
//! A controller that looks back at errors makes the energy drift, however symmetric the scheme: a step then depends on
//! which way the motion went. Here the step follows the pace Ω of the motion, a function of the state that is the same both ways,
//!
//! ```text
//!     Ω⁴ = Ω₀⁴ + Σ (q̇⁴ + q̈²)  [1/s⁴],     L = d/dt ln Ω = Σ (4 q̇³ q̈ + 2 q̈ q⃛) / (4 Ω⁴)  [1/s]
//!     ln (h₊ / h₋) = −√(h₊ h₋) L                                between the steps before and after a state
//! ```
//!
//! Turning time round exchanges `h₊` and `h₋` and changes the sign of L, which leaves the rule as it is. It is the leapfrog for `d ln h = −L dt`, so
//! that `h Ω` stays near a constant ε for good where ε is small enough. The step is set anew if `h Ω` leaves the band of 2/3 to 3/2 of ε. If the pace
//! falls so fast that the rule has no solution, or nearly none, the step grows as if it fell less. If a step fails, ε is halved. All three break the
//! symmetry, and are counted.
//!
//! Source: E. Hairer and G. Söderlind, SIAM J. Sci. Comput. 26 (2005), with logarithms in place of reciprocals, which cannot
//! lead to negative steps.

use crate::length::stepper::{Stepper, refusal};
use crate::length::stride::{HALVINGS, Stride};
use crate::watching::pace::{Pace, STEEPEST};
use catena_lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::integrator::{StepError, StepOutcome};
use catena_mechanism::motion::state::State;

/// Factor between `h Ω` and ε at which the step is set anew.
const BAND: f64 = 1.5;

/// The memory of the rule.
#[derive(Clone, Copy, Debug)]
pub struct Reversible {
    /// The length of the next step (s).
    step: f64,
    /// ε, once the run has started.
    span: Option<f64>,
    resets: usize,
}

impl Reversible {
    /// A rule whose first step is `step` (s).
    pub fn new(step: f64) -> Self {
        Reversible { step, span: None, resets: 0 }
    }

    /// The length of the next step (s).
    pub fn step(&self) -> f64 {
        self.step
    }

    /// How often the symmetry has been broken.
    pub fn resets(&self) -> usize {
        self.resets
    }

    /// Whether the run has started.
    pub fn started(&self) -> bool {
        self.span.is_some()
    }

    /// Takes the pace at the start of the run.
    pub fn start(&mut self, pace: &Pace) {
        self.span = Some(pace.span(self.step));
    }

    /// Takes the pace at the end of a step.
    pub fn follow(&mut self, pace: &Pace) {
        let Some(span) = self.span else { return };
        let falls = self.step * pace.growth < STEEPEST;
        self.step = pace.next(self.step);
        let off = pace.span(self.step) / span;
        let astray = !(1.0 / BAND..=BAND).contains(&off);
        self.resets += usize::from(falls || astray);
        if astray {
            // Twice, because the middle of the step depends on its length.
            let first = span / pace.rate;
            self.step = first * (-0.5 * first * pace.growth).clamp(-0.5, 0.5).exp();
        }
    }

    /// One step.
    pub(crate) fn advance(
        &mut self,
        stepper: &mut Stepper,
        mechanism: &Mechanism,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let mut outcome = StepOutcome::default();
        if !self.started()
            && let Some(pace) = stepper.pace(mechanism, state)
        {
            self.start(&pace);
        }
        let (mut halvings, mut guess) = (0, stepper.first_guess());
        loop {
            let Stride { length, end, reaches } = Stride::towards(until, state.time, self.step);
            let attempt = stepper.kernel.attempt(mechanism, length, &StopRule::ROUNDING, guess);
            outcome.cost.iterations += attempt.iterations();
            if let Attempt::Converged { exact, .. } = attempt {
                stepper.finish(mechanism, state);
                outcome.exact = exact;
                stepper.accept(mechanism, state, length, end, &mut outcome)?;
                // A step cut off at the end of the run does not determine the next.
                if let (false, Some(pace)) = (reaches, stepper.pace(mechanism, state)) {
                    self.follow(&pace);
                }
                return Ok(outcome);
            }
            outcome.cost.reject(refusal(&attempt));
            if guess == Guess::Past {
                guess = Guess::Plain;
                continue;
            }
            self.fail(length);
            halvings += 1;
            stepper.look_after_failure(mechanism, state, length);
            if halvings > HALVINGS {
                stepper.abandon(&outcome.cost);
                return Err(stepper.failure(mechanism, state.time, length, &attempt));
            }
            guess = stepper.first_guess();
        }
    }

    /// A step of this length (s) failed: shorter ones from now on. A step cut off at the end of the run does not change ε.
    pub fn fail(&mut self, length: f64) {
        self.resets += 1;
        if length >= self.step {
            self.span = self.span.map(|span| 0.5 * span);
        }
        self.step = 0.5 * length;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_for_which_the_rule_has_no_solution_is_counted() {
        let mut rule = Reversible::new(0.1);
        rule.start(&Pace { rate: 2.0, growth: 0.0 });
        rule.follow(&Pace { rate: 2.0, growth: 0.0 });
        assert_eq!((rule.step(), rule.resets()), (0.1, 0));
        // Twice as long at half the pace, with a fall of −0.7 over the step: hΩ stays within its band.
        rule.follow(&Pace { rate: 1.0, growth: -7.0 });
        assert_eq!(rule.resets(), 1);
        assert!(rule.step() > 0.2, "{}", rule.step());
    }

    #[test]
    fn a_last_step_that_fails_is_halved_and_whoever_goes_on_has_the_steps_of_before() {
        let pace = Pace { rate: 2.0, growth: 0.0 };
        let mut rule = Reversible::new(0.1);
        rule.start(&pace);
        rule.fail(1e-3);
        assert_eq!((rule.step(), rule.resets()), (5e-4, 1));
        rule.follow(&pace);
        assert_eq!(rule.step(), 0.1);
        // A whole one that fails is too long for good.
        rule.fail(0.1);
        rule.follow(&pace);
        assert_eq!(rule.step(), 0.05);
    }
}

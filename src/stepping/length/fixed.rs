//! Fixed steps: they end on the grid `t₀ + n h`, counted, so that no rounding accumulates in the time.
//!
//! A step that does not converge is tried again without the past, then halved, and the grid is met again afterwards. A step of a closed mechanism
//! that has come out on another branch of a singular position, which its energy shows, is treated the same way. If the shortest step fails, too, the
//! run ends.

use crate::length::stepper::{Stepper, refusal};
use crate::length::stride::HALVINGS;
use catena_lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{StepError, StepOutcome};
use catena_mechanism::motion::state::State;

/// A step of a closed mechanism that changes the energy by this part of the kinetic energy has solved its equations on another
/// branch of a singular position: it is tried again, and shortened.
const ANOTHER_MOTION: f64 = 0.25;
/// But not where forces change it by no more over this distance (m; rad): another branch is farther away.
const NEAR: f64 = 1e-9;

/// A grid point this close, in steps, is where rounding left us, not a step to make.
const CLOSE: f64 = 1e-7;

/// The grid, and when an iteration ends.
#[derive(Clone)]
pub(crate) struct FixedSteps {
    step: f64,
    rule: StopRule,
    /// t₀.
    origin: f64,
    /// n of the grid point ahead.
    points: u64,
    /// Whether the grid stays where it is when the motion begins anew.
    lasting: bool,
}

impl FixedSteps {
    /// Steps of `step` seconds.
    pub fn new(step: f64, rule: StopRule) -> Self {
        FixedSteps { step, rule, origin: 0.0, points: 0, lasting: false }
    }

    /// The length of a step (s).
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Lays the grid anew.
    pub fn begin_at(&mut self, time: f64) {
        if !self.lasting {
            (self.origin, self.points) = (time, 0);
        }
    }

    /// Lays the grid from this time on for good (s).
    pub fn lay(&mut self, origin: f64, time: f64) {
        let points = ((time - origin) / self.step).floor().max(0.0) as u64;
        (self.origin, self.points, self.lasting) = (origin, points, true);
    }

    /// The grid point ahead, or `until` if that comes first.
    fn target(&mut self, time: f64, until: f64) -> f64 {
        while self.origin + self.points as f64 * self.step <= time + CLOSE * self.step {
            self.points += 1;
        }
        let point = self.origin + self.points as f64 * self.step;
        if point > until || until - point < CLOSE * self.step { until } else { point }
    }

    /// One step.
    pub fn advance(
        &mut self,
        stepper: &mut Stepper,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let target = self.target(state.time, until);
        let mut outcome = StepOutcome::default();
        let mut length = target - state.time;
        let (mut halvings, mut guess) = (0, stepper.first_guess());
        loop {
            let attempt = stepper.attempt(mechanism, inputs, state, length, &self.rule, guess);
            outcome.cost.iterations += attempt.iterations();
            if let Attempt::Converged { exact, .. } = attempt {
                let before = stepper.kernel.energy().kinetic;
                let energies = stepper.finish(mechanism, state);
                let allowed = ANOTHER_MOTION * before.max(energies.kinetic) + NEAR * energies.pushes;
                if !mechanism.has_closures() || energies.change.abs() <= allowed {
                    let time = if halvings == 0 { target } else { state.time + length };
                    outcome.exact = exact;
                    stepper.accept(mechanism, state, length, time, &mut outcome)?;
                    if stepper.is_damped() {
                        stepper.look_inside(mechanism, 0.0);
                    }
                    return Ok(outcome);
                }
            }
            outcome.cost.reject(refusal(&attempt));
            if guess == Guess::Past {
                guess = Guess::Plain;
                continue;
            }
            if halvings == 0 {
                stepper.look_after_failure(mechanism, state, length);
            }
            if halvings == HALVINGS {
                stepper.abandon(&outcome.cost);
                return Err(stepper.failure(mechanism, state.time, length, &attempt));
            }
            halvings += 1;
            length *= 0.5;
            guess = stepper.first_guess();
        }
    }
}

//! Forces that jump where a step is too long for a slow slip: the step is made again, shorter.
//!
//! ```text
//!     λ(h) > 0 for h < h₁,   λ(h) < 0 for h > h₁,   |λ| ≫ roundings at both sides of h₁
//! ```
//!
//! λ is the pressure of a contact, or the remaining effort of a joint, at the end of a step of length h. The equations of the stages of a step in
//! which a slip of u m/s is accelerated by much more than u/h have more than one solution. Spurious solutions have λ < 0: the contact pulls and its
//! friction accelerates the slip (observed: 1e-3 to 0.08 m/s in 75 µs). The measure by which steps are chosen sees places, and finds them no worse
//! than others. A force that has a root is located; one that changes its sign and has none has jumped from one solution to another.
//!
//! The gap of a joint at its limit is smooth, and its root is located to roundings. Near gimbal lock a step of given length may be too long to show
//! it: lengths next to each other end at places far from each other. Such a step is made again, shorter, too.

use crate::events::finding::detection::Bracket;
use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::steps::SHORTER;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Rejected, StepError, StepOutcome};

/// A force jumps if its distance from the bound is more than this many times its roundings, and does not fall.
pub(super) const JUMP: f64 = 1e4;

/// The result of the location of an event.
pub(crate) enum Located {
    /// The functions that are zero at the end of the step.
    At(Vec<Watched>),
    /// A force that jumps inside the step, or the gap of a joint in a step that is too long for it.
    Jumps(Rejected),
    /// A slip that passes near its stop, after this time (s).
    Passes { length: f64 },
}

impl Eventful {
    /// Makes the step again so that it ends at its first event, shorter and shorter while forces jump in it, or without an event if the shorter step
    /// has no event; returns the functions that are zero there. An event within `shortest` (s) of the start is there.
    pub(super) fn end_at_first(
        &mut self,
        inputs: Inputs,
        first: Bracket,
        shortest: f64,
        outcome: &mut StepOutcome,
    ) -> Result<Vec<Watched>, StepError> {
        let since = self.trial.origin.time;
        let mut length = self.workspaces.active().small.time - since;
        let mut bracket = Some(first);
        while let Some(found) = bracket {
            let why = match self.locate(inputs, found, outcome)? {
                Located::At(all) => return Ok(all),
                Located::Jumps(why) => {
                    length *= SHORTER;
                    why
                }
                Located::Passes { length: before } => {
                    length = before;
                    // Directions have followed the slip to the end of the step.
                    let origin = self.trial.origin.clone();
                    self.note_slips(&origin);
                    Rejected::SlipTurned
                }
            };
            outcome.cost.reject(why);
            self.workspaces.active_mut().go_back(since, &self.model.recipe);
            if length <= shortest {
                return Err(StepError::NotAccurate { time: since, step: length });
            }
            let again = self.step_towards(inputs, since, since + length)?;
            outcome.take_again(&again);
            bracket = self.detect(inputs, since, None);
        }
        Ok(Vec::new())
    }
}

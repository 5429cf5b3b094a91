//! Events at the start of a step: an element that changes its state as soon as it has taken it.
//!
//! ```text
//!     φ < 0 from the start of a step of length h on      ─▶ the same in the least step hₘ = h/16ᵐ:  the event is at the start
//!                                                        ─▶ not there, or no such step:            h/16, h/256, … until an event is inside or none
//! ```
//!
//! A function that is negative from the start on may be so on the dense output of a long step alone, and so may the rate of a joint that stops as soon as it
//! slides. Most are so in truth, as the force of a contact that an event has left without any, and that falls: the least step is asked first, and
//! those between are made only if it does not say so.

use crate::events::finding::detection::Bracket;
use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::steps::SHORTER;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Rejected, StepError, StepOutcome};

/// A step is made shorter this often at most before an element is believed to change its state at once.
const SHORTENED: usize = 8;
/// The dense output of a step does not resolve roots that are nearer to its start than this part of its length.
const EARLY: f64 = SHORTER * SHORTER * SHORTER * SHORTER;

impl Eventful {
    /// The first bracket of an event in the step that was made from a time (s) on; an event that is nearer to its start than `shortest` (s) is there. A step
    /// with an event at its start is made again, shorter.
    pub(super) fn first_bracket(
        &mut self,
        inputs: Inputs,
        since: f64,
        shortest: f64,
        outcome: &mut StepOutcome,
    ) -> Result<Option<Bracket>, StepError> {
        let mut bracket = self.detect(inputs, since, None);
        for count in 0..SHORTENED {
            let length = self.workspaces.active().small.time - since;
            let shorter = SHORTER * length;
            if !bracket.is_some_and(|found| self.is_early(found, since, length)) || shorter < shortest {
                break;
            }
            let least = least(shorter, shortest);
            if count == 0 && least < shorter {
                match self.look_again(inputs, since, least, outcome) {
                    Ok(Some(found)) if found.at_start || found.root - since < shortest => return Ok(Some(found)),
                    Ok(_) | Err(StepError::NotConverged { .. } | StepError::NotAccurate { .. }) => {}
                    Err(error) => return Err(error),
                }
            }
            bracket = self.look_again(inputs, since, shorter, outcome)?;
        }
        Ok(bracket)
    }

    /// Whether an event is at the start of a step of this length (s), or is nearer to it than its dense output resolves.
    fn is_early(&self, found: Bracket, since: f64, length: f64) -> bool {
        let slides = matches!(self.trial.watched[found.watched], Watched::Slide(_));
        found.at_start || slides && found.root - since < EARLY * length
    }

    /// Makes the step again with this length (s), and looks for its first bracket.
    fn look_again(
        &mut self,
        inputs: Inputs,
        since: f64,
        length: f64,
        outcome: &mut StepOutcome,
    ) -> Result<Option<Bracket>, StepError> {
        outcome.cost.reject(Rejected::EventAtStart);
        let piece = self.workspaces.active_mut();
        piece.go_back(since, &self.model.recipe);
        let again = piece.step(&self.model.whole, inputs, since + length)?;
        outcome.take_again(&again);
        Ok(self.detect(inputs, since, None))
    }
}

/// The last of the lengths that fall from this one by [`SHORTER`] that is not below the shortest (s).
fn least(length: f64, shortest: f64) -> f64 {
    let mut least = length;
    while SHORTER * least >= shortest {
        least *= SHORTER;
    }
    least
}

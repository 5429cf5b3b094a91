//! Before a run is said to be off: a second opinion, and whether finer steps would help.

use crate::events::crowded::least_part;
use crate::events::price::{are_few, is_cheap};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::beside::Beside;
use crate::simulation::tolerance::error_estimate::{By, ErrorEstimate};
use crate::simulation::tolerance::event_order::first_difference;
use crate::simulation::tolerance::forecast::FINEST;
use crate::simulation::tolerance::terms::Terms;
use crate::stepping::length::stage_choice::StageChoice;

/// A run that steps over events for this part of its time does not restart.
const STEPPED_OVER: f64 = 1.0 / 8.0;

/// A run whose error at its end is at most this many times the accuracy is worth making again with shorter steps over events. What is further off has parted
/// or will.
const NEAR: f64 = 30.0;
/// It aims at this part of the accuracy: the errors of steps of first order are in proportion to what they are made for.
const AIM: f64 = 0.3;
/// The largest and the least part of the accuracy that such steps are then made for.
const PARTS: [f64; 2] = [0.1, 0.01];

/// Begins a separate run beside one with this stop and these stages, from a state on.
type Ask = fn(&Mechanism, &Terms, f64, StageChoice, &State) -> Option<Beside>;

impl ErrorEstimate<'_> {
    /// The stop with which the run restarts, if it is too coarse for its error (m) and for that of ringing (m), and may restart.
    pub(super) fn finer_stop(&mut self, state: &State, error: f64, ringing: f64, run: &RunIntegrator) -> Option<f64> {
        if !self.may_begin_again || self.stop <= FINEST {
            return None;
        }
        let predicted = self.forecast.too_coarse(state.time, self.earlier + self.steps, error, ringing)?;
        self.gains_by_finer_steps(state, run).then(|| self.forecast.finer(predicted, self.begun > 1))
    }

    /// The distance by which the order of blows can have moved bodies or joints up to an instant (s) (m or rad): a finer run leaves out less, and shows it.
    pub(super) fn doubt(&self, time: f64, run: &RunIntegrator) -> f64 {
        match &self.by {
            By::Beside(beside) if beside.is_finer() => 0.0,
            _ => run.doubt_of_blows(time),
        }
    }

    /// The error of the run (m), from which the motion beside it is this far off (m), as another one tells it: a separate run instead of a carried
    /// companion, a finer one instead of a coarser one. It stays beside the run if it is nearer, or refutes a doubt. No
    /// finer one is asked if a scene of more than a few bodies was stepped over events for an eighth of the time: a coarser run tells the error of such steps
    /// by the law of a finer one, for a quarter of its cost.
    pub(super) fn second_opinion(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        error: f64,
        run: &mut RunIntegrator,
    ) -> f64 {
        let (Some(origin), false) = (&self.origin, self.asked) else { return error };
        let (ask, carried): (Ask, bool) = match self.by {
            By::Nothing => return error,
            By::Carried => (Beside::coarser, true),
            By::Beside(_) if self.steps_over_events(state, run) && !are_few(mechanism.velocity_count) => return error,
            By::Beside(_) => (Beside::finer, false),
        };
        let Some(other) = ask(mechanism, &self.terms, self.stop, self.stages, origin) else { return error };
        let off = error + self.doubt(state.time, run);
        let before = std::mem::replace(&mut self.by, By::Beside(Box::new(other)));
        // No motion from the origin shows less than the error there.
        match self.error(mechanism, state, run).map(|told| told.max(self.shown)) {
            Some(told) if told < off => {
                self.asked = !carried;
                if carried {
                    run.leave_companion();
                }
                told
            }
            _ => {
                self.asked = true;
                self.by = before;
                error
            }
        }
    }

    /// Whether finer steps may carry the run on to a state, as far as is known; it does not restart any more if they do not. Steps over events have the
    /// length that the tolerance gives them, whatever the stop: where they are an eighth of the run so far, a finer stop makes them no better. The same is true
    /// of steps over slips, in which forces may not be unique besides.
    pub(super) fn gains_by_finer_steps(&mut self, state: &State, run: &RunIntegrator) -> bool {
        let over_slips = run.description().over_slips_steps > 0;
        if over_slips || self.steps_over_events(state, run) {
            self.may_begin_again = false;
            return false;
        }
        let Some(differ) = self.difference(run) else { return true };
        self.may_begin_again = self.horizon.is_worth(differ, self.stop, self.terms.end - self.terms.start);
        self.may_begin_again
    }

    /// Whether the run has stepped over events for an eighth of its time so far.
    fn steps_over_events(&self, state: &State, run: &RunIntegrator) -> bool {
        run.description().first_order_time >= STEPPED_OVER * (state.time - self.terms.start)
    }

    /// The part of the accuracy that steps over events are made for if the run restarts because of them: at its end, once, and if its estimated error (m) is
    /// near the accuracy. In the middle of a run it is not known whether motions part. Piles for which exact steps are too dear keep their steps over events.
    pub(super) fn finer_over_events(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        estimate: f64,
        run: &RunIntegrator,
    ) -> Option<f64> {
        let Terms { end, tolerance, .. } = self.terms;
        if !self.may_refine || state.time < end || !is_worth_refining([estimate, tolerance], run.smeared()) {
            return None;
        }
        self.may_refine = false;
        let mut closed = Vec::new();
        run.contacts(mechanism, state, &mut closed);
        if !is_cheap(mechanism.velocity_count, closed.len()) {
            return None;
        }
        let (method, wanted) = (run.description(), (AIM * tolerance / estimate).clamp(PARTS[1], PARTS[0]));
        // Shorter ones would be exact steps, which cost a robot that collapses ten times as much as the run.
        let mean = method.first_order_time / method.first_order_steps.max(1) as f64;
        let least = if are_few(mechanism.velocity_count) { 0.0 } else { least_part(mean) };
        Some(wanted.max(least.min(1.0)))
    }

    /// When the run and its separate companion first meet different events (s). A companion that alone steps over events does not say which it met.
    pub(super) fn difference(&self, run: &RunIntegrator) -> Option<f64> {
        let By::Beside(beside) = &self.by else { return None };
        if beside.hides_events(run) {
            return None;
        }
        first_difference(&self.events, &beside.events)
    }
}

/// Whether a run with this estimated error and accuracy (m) may reach the accuracy with shorter steps over events, where these are the sums of the squared
/// lengths of such steps (s²) and of the lengths of steps over jams (s). Steps over jams have the length that a jam asks for, whatever the accuracy.
fn is_worth_refining([estimate, accuracy]: [f64; 2], [over_events, _over_jams]: [f64; 2]) -> bool {
    over_events > 0.0 && estimate > accuracy && estimate <= NEAR * accuracy
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_over_jams_alone_are_no_reason_to_begin_a_run_again() {
        // Four bricks that topple: the run was made again with the same two steps over jams, and ended at the same place.
        assert!(!is_worth_refining([2.3e-5, 1e-6], [0.0, 1e-6]));
        assert!(is_worth_refining([2.3e-5, 1e-6], [1e-7, 1e-6]));
        assert!(!is_worth_refining([0.9e-6, 1e-6], [1e-7, 0.0]) && !is_worth_refining([3.1e-5, 1e-6], [1e-7, 0.0]));
    }
}

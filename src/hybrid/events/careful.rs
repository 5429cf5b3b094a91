//! Steps over slips: where contacts stay closed, and slips begin, turn, stop and reverse so often that exact steps cost more, steps over events (`crowd/`)
//! keep to the tolerance ε (m) by an estimate of their own.
//!
//! ```text
//!     q̄ = q ⊕ h w,    q̃ = q ⊕ ½h (v_k + v_{k+1}),    e = |q̄ − q̃|       midpoint and trapezoid (m)
//!     e ~ h³ where forces are smooth, h² where a slip stops or begins, h |Δv| at an impact
//!     made again, shorter:  e > b h ε;               next length:  h √(½ b h ε / e)
//! ```
//!
//! e/h is an error of the velocity, which may carry on for a second and more: it is what counts where a slip stops.
//!
//! They are made where all slips are slower than a thousandth of the largest speed so far, and no impacts are met, or where exact steps are dearer by
//! ten times what is borne, as with dozens of contacts that share their loads. An impact ends them: no length of at
//! least 10 µs keeps to the tolerance there, and the exact steps locate it. A slip of 1e-6 m/s, as of the feet of a robot that shifts its weight, turns in
//! microseconds, so that exact steps are as short, and moves its foot by a micrometre in a second.

use crate::events::crowd::step::Made;
use crate::events::crowded::Attempted;
use crate::events::integrator::Eventful;
use crate::events::parts::model::HybridModel;
use crate::events::parts::progress::Progress;
use crate::events::parts::spending::Patience;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::distance::{distance, probes};
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::StepOutcome;
use crate::mechanism::motion::state::State;

/// Lengths of steps (s): the least and the most.
const LEAST: f64 = 1e-5;
pub(super) const MOST: f64 = 2e-3;
/// b [1/s], and the part of it that a next length aims at.
const BY_TIME: f64 = 0.2;
const AIM: f64 = 0.5;
/// A next length is at most this much longer; a step that is made again is shorter at least and at most by these factors.
const LONGER: f64 = 2.0;
const SHORTER: [f64; 2] = [0.1, 0.5];
/// A slip that is slower than this part of the largest speed so far is slow.
const SLOW: f64 = 1e-3;
/// Fast slips are stepped over where exact steps are dearer by this factor.
const FAR_DEARER: f64 = 10.0;

impl Eventful {
    /// Whether exact steps are dearer than such steps would be where no impacts are met.
    pub(super) fn slips_are_dear(&self, time: f64) -> bool {
        self.overspends(time, 1.0) && self.may_step_carefully(time)
    }

    /// Whether exact steps cost more than this many times the price of such steps at a time (s).
    fn overspends(&self, time: f64, times: f64) -> bool {
        self.progress.spending.rate(time, Patience::Short) > times * self.price_of_crowds(self.progress.careful)
    }

    /// Whether such steps may keep to a tolerance from a time (s) on: slips are slow, and no impacts are met now, unless exact steps are far dearer.
    pub(super) fn may_step_carefully(&self, time: f64) -> bool {
        let HybridModel { touching, recipe, .. } = &self.model;
        let Progress { spending, beyond_horizon, .. } = &self.progress;
        let may = !(touching.pairs.is_empty() || *beyond_horizon || recipe.keeps(Rule::Crowds) || self.needs_events());
        let can = self.workspaces.crowd.is_some() && recipe.tolerance().is_some();
        // Steps over all events that keep to the tolerance, too, and are as long, are left less often.
        let (length, keeps) = self.crowd_length();
        let slow = !spending.slips_fast(time) || self.overspends(time, FAR_DEARER);
        may && can && !spending.meets_impacts(time) && slow && !(keeps && length >= MOST)
    }

    /// Whether a slip was not slow where the last step began.
    pub(super) fn slips_fast(&self) -> bool {
        let slow = SLOW * self.memory.fastest;
        let mut slides =
            self.mode.contacts.iter().zip(&self.trial.begins).filter(|(closed, _)| closed.slides.is_some());
        slides.any(|(_, slip)| slip.norm() > slow)
    }

    /// Begins such steps with one from a state towards `until`; `None` if none keeps to the tolerance, which is not tried soon again.
    pub(super) fn begin_carefully(&mut self, inputs: Inputs, state: &mut State, until: f64) -> Option<StepOutcome> {
        self.progress.is_careful = true;
        let Some((mut outcome, made)) = self.step_carefully(inputs, state, until) else {
            self.progress.is_careful = false;
            self.progress.spending.forget();
            return None;
        };
        self.progress.spells.enter(state.time);
        self.workspaces.leave_companion();
        self.progress.in_crowd = true;
        if self.is_over(&made, self.progress.careful) {
            self.leave_crowd(inputs, state, &mut outcome);
        }
        Some(outcome)
    }

    /// Makes such a step from a state towards `until`; `None` if none keeps to the tolerance.
    pub(super) fn step_carefully(
        &mut self,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Option<(StepOutcome, Made)> {
        let tolerance = self.model.recipe.tolerance()? * self.model.coarser.powi(2);
        let mut length = self.progress.careful;
        loop {
            let attempted = self.attempt_in_crowd(inputs, state, until, length);
            let (error, made) = match &attempted {
                Some(attempted) => (self.error_of(state, attempted), attempted.step),
                None => (f64::INFINITY, length),
            };
            let allowed = BY_TIME * made * tolerance;
            let longer = (AIM * allowed / error).sqrt();
            if error <= allowed
                && let Some(attempted) = attempted
            {
                self.tally.left_of_steps += error;
                // One that ends at a given instant says little of longer ones.
                let next = made * longer.clamp(SHORTER[1], LONGER);
                self.progress.careful = if made < length { next.max(length) } else { next }.clamp(LEAST, MOST);
                return Some(self.take_from_crowd(state, &attempted));
            }
            if made <= LEAST {
                return None;
            }
            length = (longer.clamp(SHORTER[0], SHORTER[1]) * made).max(LEAST);
        }
    }

    /// e of a step from a state.
    fn error_of(&self, start: &State, attempted: &Attempted) -> f64 {
        let whole = &self.model.whole;
        let Attempted { end, step, .. } = attempted;
        let rates = start.velocity.iter().zip(&end.velocity);
        let moved: Vec<f64> = rates.map(|(before, after)| 0.5 * step * (before + after)).collect();
        let mut trapezoid = start.clone();
        trapezoid.displace(whole, &moved);
        distance(&probes(whole, &trapezoid), &probes(whole, end))
    }
}

//! Efforts that jump between two steps, or at the end of one: the mode goes on under them, or is decided anew.
//!
//! ```text
//!     λ(q, v, τ) stays in its set for all held joints and closed contacts     ─▶ the mode goes on
//!     otherwise, or for a motor that changes its law                          ─▶ decided anew
//! ```
//!
//! Efforts jump where a program sets others, at ticks of motors, and at given instants of targets and of loads.

use crate::events::effects::noted::{note_bound, side_of_bound};
use crate::events::finding::detection::ONE_INSTANT;
use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::mode::{JointMode, MotorMode};
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;

impl Eventful {
    /// Takes other efforts from outside: the mode is decided anew if it cannot go on under them.
    pub(super) fn heed(&mut self, inputs: Inputs, state: &mut State) {
        if self.previous.outside == inputs.efforts {
            return;
        }
        self.previous.outside.clear();
        self.previous.outside.extend_from_slice(inputs.efforts);
        if !self.goes_on_under(inputs, state, true) {
            let exchanged = self.pass(inputs, state, &[], false);
            self.tally.lost_at_start += exchanged;
        }
    }

    /// Whether the mode goes on under efforts that have jumped: the forces that hold joints and contacts stay in their sets. A mode that was entered
    /// at this very instant was decided under the efforts before, and is decided anew. `constant` says that the efforts that have jumped are constant
    /// until the next jump.
    pub(super) fn goes_on_under(&mut self, inputs: Inputs, state: &State, constant: bool) -> bool {
        let held = self.mode.joints.iter().any(|joint| matches!(joint, JointMode::Held { .. }));
        if !held && self.mode.contacts.is_empty() {
            return true;
        }
        if self.progress.asleep
            || self.progress.undecided
            || self.progress.repeats.are_at(state.time)
            || self.previous.left.is_none()
        {
            return false;
        }
        if constant && self.is_foreseen_to_go_on(inputs, state) {
            return true;
        }
        self.trial.holding.foreseen.forget_all();
        self.trial.sample.copy_from(state);
        self.trial.forget_looks();
        let time = state.time;
        let goes_on = (Watched::after_gaps(&self.trial.watched)..self.trial.watched.len()).all(|index| {
            let mut value = [0.0];
            if self.trial.watched[index].needs_efforts() {
                self.evaluate_at_sample(inputs, time, time, &[index], &mut value);
            }
            value[0] >= 0.0
        });
        if goes_on {
            self.trial.holding.learn(&state.position);
        }
        goes_on
    }

    /// At a given instant of a target or a tick: the efforts that begin there. Whether the mode has to be decided anew.
    pub(super) fn meet_instants(&mut self, inputs: Inputs, state: &State) -> bool {
        let (before, now) = (self.trial.origin.time, state.time);
        let (mut changed, mut jumped, mut constant) = (false, false, true);
        for index in 0..self.model.elements.motors.len() {
            let next = self.model.elements.motors[index].next_instant(before);
            if (next - now).abs() > ONE_INSTANT * now.abs().max(1.0) {
                continue;
            }
            let mode = self.motor_mode(index, state);
            let follows = |mode: &MotorMode| matches!(mode, MotorMode::Given(_));
            // A new effort alone leaves the modes of moving joints unchanged.
            changed |= !(follows(&mode) && follows(&self.mode.motors[index])) && mode != self.mode.motors[index];
            constant &= follows(&mode) && follows(&self.mode.motors[index]);
            self.note_bound_at_tick(index, mode, now);
            self.mode.motors[index] = mode;
            jumped = true;
        }
        let reached = self.model.whole.next_instant(before);
        let reaches = (reached - now).abs() <= ONE_INSTANT * now.abs().max(1.0);
        changed || (jumped || reaches) && !self.goes_on_under(inputs, state, constant && !reaches)
    }

    /// Notes that a sampled motor reaches its bound at a tick (s), or comes back from it.
    fn note_bound_at_tick(&mut self, index: usize, mode: MotorMode, time: f64) {
        let motor = &self.model.elements.motors[index];
        if let (MotorMode::Given(before), MotorMode::Given(now)) = (self.mode.motors[index], mode) {
            note_bound(motor, [before, now].map(|effort| side_of_bound(motor, effort)), time, &mut self.tally.events);
        }
    }
}

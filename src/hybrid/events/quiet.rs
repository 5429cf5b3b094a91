//! Rest on contacts: bodies that have stopped moving are not simulated until something changes. Belts that rub on them go on taking work.

use crate::events::forces::closed_forces::accelerations;
use crate::events::integrator::{Eventful, InUse};
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;

/// A step is at rest if its rates are below this part of the largest speed so far, and its motion is below this (m or rad). A tolerance allows rates
/// of a tenth of it per second, and a motion of a thousandth of it.
const REST: f64 = 1e-12;
/// A step at rest has at least this length (s).
const SHORTEST_REST: f64 = 1e-3;
/// Steps in a row at rest before the mechanism sleeps.
pub(super) const QUIET: usize = 10;

/// Rates below this part of the largest speed so far are roundings of an event that has stopped all motion.
const STANDING: f64 = 1e-14;

/// Accelerations below this part of the terms that cancel in them are zero.
const ROUNDING: f64 = 1e-14;

impl Eventful {
    /// Whether a state at rest stays as it is: every acceleration is a rounding, on contacts and under efforts that do not change. A free body can
    /// also be at rest, if the forces on it cancel. Its energies and speeds would be roundings, and with them the lengths of steps.
    pub(super) fn stays_at_rest(&mut self, inputs: Inputs, state: &State) -> bool {
        let asked = !(self.mode.contacts.is_empty() || self.workspaces.active().moving.is_empty());
        if !asked
            || inputs.feedback.is_some()
            || self.model.whole.changes()
            || !self.is_driven_evenly()
            || self.rides_or_rubs()
            || state.velocity.iter().any(|rate| rate.abs() > STANDING * self.memory.fastest)
        {
            return false;
        }
        let InUse { present, response, efforts, unique } = self.in_use();
        present.mode.efforts_at(present.elements, inputs, state.time, state, efforts);
        let all = accelerations(&present, response, state, efforts, unique);
        all.iter().all(|(acceleration, size)| acceleration.abs() <= ROUNDING * size)
    }

    /// Whether every motor has a constant target and no ticks.
    fn is_driven_evenly(&self) -> bool {
        self.model.elements.motors.iter().all(|motor: &Motor| motor.period == 0.0 && motor.target.is_constant())
    }

    /// Whether all motions of the last step were too small to matter, on contacts and under efforts that do not change.
    pub(super) fn is_quiet(&self, state: &State) -> bool {
        if self.progress.asleep || self.mode.contacts.is_empty() || state.time - self.trial.origin.time < SHORTEST_REST
        {
            return false;
        }
        let wanted = self.model.recipe.tolerance().unwrap_or(0.0);
        let slow = |rate: &f64| rate.abs() <= (REST * self.memory.fastest).max(0.1 * wanted);
        let moved = self.trial.origin.position.iter().zip(&state.position).map(|(from, to)| (to - from).abs());
        moved.fold(0.0, f64::max) <= REST.max(1e-3 * wanted)
            && state.velocity.iter().all(slow)
            && self.is_driven_evenly()
            && !self.rides_or_rubs()
    }

    /// Whether a belt is among the closed contacts.
    fn rides_or_rubs(&self) -> bool {
        self.mode.contacts.iter().any(|closed| closed.contact.joint.is_belt())
    }
}

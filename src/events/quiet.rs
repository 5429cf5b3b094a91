//! Rest on contacts: bodies that have stopped moving are not simulated until something changes.

use crate::events::integrator::Eventful;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::motion::state::State;

/// Slower than this part of the fastest that any body has been, and nearer than this to where the step began (m or rad), is at rest; with a tolerance
/// slower than a tenth of it in a second, and nearer than a thousandth of it;
const REST: f64 = 1e-12;
/// in steps of at least this length (s),
const SHORTEST_REST: f64 = 1e-3;
/// so many in a row.
pub(super) const QUIET: usize = 10;

impl Eventful {
    /// Whether nothing has moved in the last step by more than does not matter, on contacts and under efforts that do not change.
    pub(super) fn is_quiet(&self, state: &State) -> bool {
        if self.asleep || self.mode.contacts.is_empty() || state.time - self.origin.time < SHORTEST_REST {
            return false;
        }
        let wanted = self.recipe.tolerance().unwrap_or(0.0);
        let slow = |rate: &f64| rate.abs() <= (REST * self.memory.fastest).max(0.1 * wanted);
        let moved = self.origin.position.iter().zip(&state.position).map(|(from, to)| (to - from).abs());
        let constant = |motor: &Motor| motor.period == 0.0 && motor.target.is_constant();
        moved.fold(0.0, f64::max) <= REST.max(1e-3 * wanted)
            && state.velocity.iter().all(slow)
            && self.elements.motors.iter().all(constant)
    }
}

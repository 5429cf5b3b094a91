//! Projects velocities so that the rates along given rows are zero: elements that touch come to rest.
//!
//! ```text
//!     minimise ½ dvᵀ H dv   subject to  W (v + dv) = 0          dv = Y Wᵀ P,   D P = −W v
//! ```

use crate::events::effects::decision::Scene;
use crate::instant::cone::bounded::minimise;
use crate::instant::holding::blocks::Rows;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::energy::{Energy, energy_with_forces};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// The energy of a state (J).
pub(crate) fn energy(mechanism: &Mechanism, state: &State) -> Energy {
    energy_with_forces(mechanism, &state.position, &body_states(mechanism, state))
}

/// Takes from the velocities what a state has more than it had before it was moved (J); returns the energy that this has taken in all (J).
pub(crate) fn keep_from_gaining(scene: &Scene, state: &mut State, before: f64) -> f64 {
    let after = energy(scene.whole, state);
    let gained = after.total() - before;
    if gained > 0.0 && after.kinetic > 0.0 {
        let factor = (1.0 - gained / after.kinetic).max(0.0).sqrt();
        state.velocity.iter_mut().for_each(|rate| *rate *= factor);
    }
    before - energy(scene.whole, state).total()
}

/// Velocities without rates along some rows, with the least change in the metric of the mass matrix; returns the energy that this takes (J).
pub(crate) fn bring_rows_to_rest(scene: &mut Scene, state: &mut State, rows: Vec<Vec<f64>>) -> f64 {
    if rows.is_empty() {
        return 0.0;
    }
    let rows = Rows::new(scene.response, state, rows);
    let rates = rows.rates(&state.velocity);
    let unbounded = vec![(f64::NEG_INFINITY, f64::INFINITY); rates.len()];
    let impulses = minimise(&rows.square, &rates, &unbounded).efforts;
    rows.add(&impulses, &mut state.velocity);
    impulses.iter().zip(&rates).map(|(impulse, rate)| -0.5 * rate * impulse).sum()
}

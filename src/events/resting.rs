//! Velocities without rates along some rows: how what touches comes to rest.
//!
//! ```text
//!     minimise ½ dvᵀ H dv   subject to  W (v + dv) = 0          dv = Y Wᵀ P,   D P = −W v
//! ```

use crate::events::decision::Scene;
use crate::instant::blocks::Rows;
use crate::instant::cone::bounded::minimise;
use crate::mechanism::motion::state::State;

/// Velocities without rates along some rows, with the least change in the metric of the mass matrix; returns the energy that this takes (J).
pub(super) fn bring_rows_to_rest(scene: &mut Scene, state: &mut State, rows: Vec<Vec<f64>>) -> f64 {
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

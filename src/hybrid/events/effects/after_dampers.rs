//! The motion after an impact, once its transient in hard dampers is over.
//!
//! ```text
//!     S = {damped joints with c Y T > 1}               c: damping [N m s/rad or N s/m];  Y: mobility [1/(kg m²) or 1/kg];  T: a time (s)
//!     v_t = v + Y Wᵀ x,   W_S v_t = 0,   0 ≤ x_R ⟂ W_R v_t ≥ 0               R: limits and contacts at rest
//! ```
//!
//! A damper of 1e8 N s/m between two bodies decelerates a rebound by 1e8 m/s², for 1e-8 s: the rebound would return within a height of 1e-8 m if that force
//! stayed, while the bodies go on together with the momentum that is left.

use crate::events::effects::decision::Scene;
use crate::instant::cone::bounded::minimise;
use crate::instant::dynamics::dampings::dampings;
use crate::instant::holding::blocks::{Row, Rows};
use crate::mechanism::motion::state::State;

/// The state with the velocities v_t; `None` if no damper is that hard for a time (s).
pub(crate) fn after_dampers(scene: &mut Scene, state: &State, rests: &[Row], time: f64) -> Option<State> {
    let damped = dampings(scene.whole, scene.elements.motors.iter());
    if damped.is_empty() {
        return None;
    }
    let mobilities = scene.response.diagonal(state, damped.iter().map(|(freedom, _)| *freedom));
    let hard = damped.iter().zip(mobilities).filter(|((_, damping), mobility)| damping * mobility * time > 1.0);
    let freedoms: Vec<usize> = hard.map(|((freedom, _), _)| *freedom).collect();
    if freedoms.is_empty() {
        return None;
    }
    let row = |&freedom: &usize| {
        let mut entries = vec![0.0; state.velocity.len()];
        entries[freedom] = 1.0;
        Row::from(entries)
    };
    let mut bounds = vec![(f64::NEG_INFINITY, f64::INFINITY); freedoms.len()];
    bounds.resize(freedoms.len() + rests.len(), (0.0, f64::INFINITY));
    let rows: Vec<Row> = freedoms.iter().map(row).chain(rests.iter().cloned()).collect();
    let rows = Rows::new(scene.response, state, rows);
    let mut settled = state.clone();
    rows.add(&minimise(&rows.square, &rows.rates(&state.velocity), &bounds).efforts, &mut settled.velocity);
    Some(settled)
}

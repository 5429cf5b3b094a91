//! Whether anything can give way where limits and contacts close: joints that are moved in time may leave no velocity that is allowed.
//!
//! With the rows N of all limits and contacts that are met along their normals, `D = N Y Nᵀ` and their rates `u⁻`, velocities that keep them apart exist
//! if and only if no pushes y hold each other while they approach (Farkas):
//!
//! ```text
//!     ∃ P: D P + u⁻ ≥ 0     ⟺     no y ≥ 0 with D y = 0, yᵀ u⁻ < 0
//!     P(ε) = argmin  ½ Pᵀ (D + ε d 1) P + u⁻ᵀ P,  P ≥ 0,  d = max Dᵢᵢ:       D P(ε) + u⁻ ≥ −ε d P(ε) → 0, or it stays negative
//! ```
//!
//! Friction needs nothing more: if the normals can part, Coulomb's law has a solution. Without moved joints rest is always allowed, and nothing is
//! looked at.

use crate::events::effects::decision::Scene;
use crate::events::effects::impact::Meeting;
use crate::instant::cone::bounded::minimise;
use crate::instant::holding::blocks::{Of, Row, Rows};
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// ε: far above the roundings of D, far below the part of a rate that is missed.
const SOFT: f64 = 1e-12;
/// A rate that is this part of the fastest approach and cannot be stopped is no rounding.
const MISSED: f64 = 1e-3;

/// The limit or contact that still approaches most although all push, with the velocities before and after the impulses.
pub(crate) fn blocked(scene: &mut Scene, before: &[f64], after: &State, meetings: &[Meeting]) -> Option<Of> {
    if !scene.whole.moves_joints() {
        return None;
    }
    let fastest = meetings.iter().map(|meeting| -meeting.rate(before)).fold(0.0, f64::max);
    // NaN is no allowed rate: nothing has answered.
    let allowed = |meeting: &Meeting| meeting.rate(&after.velocity) >= -meeting.rest.max(MISSED * fastest);
    if meetings.iter().all(allowed) {
        return None;
    }
    let normals: Vec<Row> = meetings.iter().map(|meeting| meeting.block.rows[0].clone()).collect();
    let rows = Rows::new(scene.response, after, normals);
    let rates = rows.rates(before);
    let largest = rows.square.diagonal().max();
    let mut left = DVector::from_column_slice(&rates);
    if largest > 0.0 {
        let softened = &rows.square + DMatrix::identity(rates.len(), rates.len()) * (SOFT * largest);
        let pushes = vec![(0.0, f64::INFINITY); rates.len()];
        left += &rows.square * DVector::from_vec(minimise(&softened, &rates, &pushes).efforts);
    }
    let (worst, rate) = left.argmin();
    let can_part = rate >= -MISSED * fastest;
    (!can_part).then(|| meetings[worst].block.of)
}

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
use crate::events::effects::resting::energy;
use crate::instant::cone::bounded::minimise;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Of, Row, Rows};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// ε: far above the roundings of D, far below the part of a rate that is missed.
const SOFT: f64 = 1e-12;
/// An answer below this part of that without closures is rounding.
const ROUNDING: f64 = 1e-15;
/// Impulses that do more work than this times the kinetic energy have met no mass.
const WILD: f64 = 1e6;
/// A rate that is this part of the fastest approach and cannot be stopped is no rounding.
const MISSED: f64 = 1e-3;

/// The limit or contact that still approaches most although all push, with the velocities before and after these impulses along the normals.
pub(crate) fn blocked(
    scene: &mut Scene,
    before: &[f64],
    after: &State,
    meetings: &[Meeting],
    impulses: &[f64],
) -> Option<Of> {
    if !scene.whole.moves_joints() {
        return None;
    }
    let rates: Vec<f64> = meetings.iter().map(|meeting| meeting.rate(before)).collect();
    let fastest = rates.iter().fold(0.0, |most: f64, rate| most.max(-rate));
    let kinetic = energy(scene.whole, &State { velocity: before.to_vec(), ..after.clone() }).kinetic;
    // Where only roundings answer, impulses have no bound. NaN is nothing allowed: nothing has answered.
    let allowed = |number: usize| {
        let meeting = &meetings[number];
        let work = (impulses[number] * rates[number]).abs();
        meeting.rate(&after.velocity) >= -meeting.rest.max(MISSED * fastest) && work <= WILD * kinetic
    };
    if (0..meetings.len()).all(allowed) {
        return None;
    }
    let normals: Vec<Row> = meetings.iter().map(|meeting| meeting.block.rows[0].clone()).collect();
    let own = answers_of_tree(scene.whole, after, &normals);
    let mut square = Rows::new(scene.response, after, normals).square;
    for (number, own) in own.into_iter().enumerate() {
        if square[(number, number)] <= ROUNDING * own {
            square.row_mut(number).fill(0.0);
            square.column_mut(number).fill(0.0);
        }
    }
    let largest = square.diagonal().max();
    let mut left = DVector::from_column_slice(&rates);
    if largest > 0.0 {
        let softened = &square + DMatrix::identity(rates.len(), rates.len()) * (SOFT * largest);
        let pushes = vec![(0.0, f64::INFINITY); rates.len()];
        left += &square * DVector::from_vec(minimise(&softened, &rates, &pushes).efforts);
    }
    let (worst, rate) = left.argmin();
    let can_part = rate >= -MISSED * fastest;
    (!can_part).then(|| meetings[worst].block.of)
}

/// An upper bound of the order of `N H⁻¹ Nᵀ` of the tree without closures: what closed joints leave of it may be a rounding.
fn answers_of_tree(whole: &Mechanism, state: &State, rows: &[Row]) -> Vec<f64> {
    let mut open = whole.clone();
    open.loops.clear();
    open.mimics.clear();
    let of_freedoms = Response::new(&open).diagonal(state, 0..whole.velocity_count);
    let answer = |row: &Row| row.iter().zip(&of_freedoms).map(|(entry, own)| entry * entry * own).sum();
    rows.iter().map(answer).collect()
}

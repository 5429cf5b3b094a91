//! Repeated solves where light freedoms have lent inertia ([`catena_mechanism::structure::ranks::lending`]): its effect is removed round by round.
//!
//! The matrix has `H + w`, the equations have H. The correction of a round is δ, and the correction of its multipliers δμ:
//!
//! ```text
//!     (H + w) δ − Jᵀ δμ = w δ_before,      J δ = −gap
//! ```
//!
//! so that the sum of all rounds solves `H δ = Jᵀ μ`. A round leaves some 1e-4 of the one before.

use crate::coupled::known::Known;
use crate::coupled::system::{Coupled, One};
use crate::numbers::lanes::Lanes;
use crate::plan::tree::Plan;

/// Largest number of repetitions.
pub(crate) const ROUNDS: usize = 40;

/// Corrections of velocities and accelerations below this part of them are rounding.
const ROUNDED: f64 = 1e-15;

/// When repetitions of a solve end: rounding does not fall any more.
#[derive(Clone, Default)]
pub(crate) struct Rounds {
    last: Option<(f64, f64)>,
}

impl Rounds {
    /// Whether another round is worth it: the gap still falls, or the correction owed for lent inertia still falls and is not rounding.
    pub(crate) fn go_on(&mut self, gap: f64, owed: f64) -> bool {
        let Some((last_gap, last_owed)) = self.last else {
            self.last = Some((gap, f64::INFINITY));
            return gap != 0.0 && !gap.is_nan();
        };
        self.last = Some((gap, owed));
        let owes = owed > ROUNDED && owed < 0.5 * last_owed;
        !gap.is_nan() && ((gap != 0.0 && gap < 0.5 * last_gap) || owes)
    }
}

impl Coupled<One> {
    /// Repeats a solve for the present gaps until the correction owed by light freedoms for their lent inertia is rounding; `correction` becomes the
    /// sum.
    pub(crate) fn settle_lent(&mut self, tree: &Plan, increment: &mut [One], correction: &mut [f64]) {
        if self.known.lent.is_empty() {
            return;
        }
        let mut sum = correction.to_vec();
        let mut last = f64::INFINITY;
        for _ in 0..ROUNDS {
            let latest = largest(correction);
            if latest <= ROUNDED * largest(&sum) || latest >= 0.5 * last || latest.is_nan() {
                break;
            }
            last = latest;
            self.gaps.fill(One::zero());
            self.owe(correction, true);
            self.solve_again(tree, increment);
            for ((sum, correction), increment) in sum.iter_mut().zip(&mut *correction).zip(&*increment) {
                *correction = increment.to_array()[0];
                *sum += *correction;
            }
        }
        correction.copy_from_slice(&sum);
    }

    /// Adds an effort to light freedoms: the latest correction times their lent inertia. The matrix has `H + w`, the equation H, so that
    /// `(H + w) δ − Jᵀ δμ = w δ_before`.
    pub(crate) fn owe(&mut self, correction: &[f64], corrected: bool) {
        for ((effort, &lent), correction) in self.efforts.iter_mut().zip(&self.known.lent).zip(correction) {
            *effort = One::splat(if corrected { lent * correction } else { 0.0 });
        }
    }
}

/// The largest of the latest corrections of light freedoms, as a part of the largest value; zero without lent inertia.
pub(crate) fn owed(known: &Known, correction: &[f64], values: &[f64]) -> f64 {
    if known.lent.is_empty() {
        return 0.0;
    }
    largest(correction) / largest(values).max(f64::MIN_POSITIVE)
}

/// The largest entry, without its sign.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |most, value| most.max(value.abs()))
}

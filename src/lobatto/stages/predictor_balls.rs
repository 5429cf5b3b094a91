//! The past of ball joints, whose rotation vectors from the old start differ from the rotation vectors from the new one.
//!
//! ```text
//!     y_n = log(exp(−θ_s) exp(θ_n)),     exp and log between rotation vectors (rad) and unit quaternions
//! ```

use crate::numbers::algebra::Vector;
use crate::numbers::lanes::Lanes;
use crate::numbers::reductions::at_end;
use crate::numbers::rotations::compose;
use crate::numbers::series::{half_angle, polynomial};
use crate::stages::predictor::Predictor;
use crate::stages::unknowns::Unknowns;

impl<V: Lanes> Predictor<V> {
    /// The past of a ball joint: rotation vectors from the new start, `log(exp(−θ_s) exp(θ_n))`.
    #[inline(always)]
    pub(crate) fn learn_ball(&mut self, unknowns: &Unknowns<V>, freedom: usize) {
        let active = unknowns.coefficients.active;
        let displacement = &unknowns.displacement[freedom..freedom + 3];
        let turn = Vector([displacement[0], displacement[1], displacement[2]]);
        let (w, sine) = half_angle(turn.dot(turn));
        let u = turn.times(sine);
        let [x, y, z] = u.0;
        let back = Vector::splat(&[-at_end(x, active), -at_end(y, active), -at_end(z, active)]);
        let (w, u) = compose(V::splat(at_end(w, active)), back, w, u);
        let vector = u.times(twice_angle_over_sine(w));
        // Stage 1, in the last lane in use: its displacement from the end of the step is zero.
        let (moved, first) = (unknowns.coefficients.moved, V::splat(1.0) - unknowns.coefficients.moved);
        for (axis, entry) in vector.0.into_iter().enumerate() {
            let at_first = -at_end(turn.0[axis], active);
            self.extrapolation.past[freedom + axis] = first.mul_add(V::splat(at_first), entry * moved);
        }
    }
}

/// `2 ψ / sin ψ` from `w = cos ψ`, the half angle of a rotation: with `z = (1 − w)/2`,
///
/// ```text
///     ψ / sin ψ = arcsin √z / √(z (1 − z)) = Σ_k 4ᵏ (k!)² / (2k + 1)!  zᵏ
/// ```
///
/// Sixteen terms are good to rounding for rotations up to 1.5 rad and to 1e-5 at half a turn: enough for a guess.
#[inline(always)]
fn twice_angle_over_sine<V: Lanes>(w: V) -> V {
    const TERMS: [f64; 16] = {
        let mut terms = [2.0; 16];
        let mut k = 1;
        while k < 16 {
            terms[k] = terms[k - 1] * (2 * k) as f64 / (2 * k + 1) as f64;
            k += 1;
        }
        terms
    };
    let half = V::splat(0.5);
    polynomial(&TERMS, w.neg_mul_add(half, half))
}

//! A body on a hinge that the world holds: one equation a row, where a body in space has six.
//!
//! It turns about an axis `a` that never moves, by `N_i = s_i â + v_i â²` with the sine `s = sin φ` and the versine `v = 1 − cos φ`. Only the torque
//! about `a` of its residual ([`crate::equations::residual`]) is needed, and two numbers are mixed instead of twelve:
//!
//! ```text
//!     S_k = Σ_i B_ki (s_i − h c_i ω),   V_k = Σ_i B_ki v_i
//!     e_k = I (S_k cos φ_k + V_k sin φ_k) − h² m (g·(a × c) cos φ_k + g·(a × (a × c)) sin φ_k)        [kg m²]
//!     I   = aᵀ J a + m |a × c|²                                                                       [kg m²]
//! ```
//!
//! with the arm `c` from the axis to the centre of mass and the rate `ω`, both at the start of the step. That is `a·(e_k + c_k × f_k)` of the
//! general terms, because `â³ = −â` and `tr(â² Σ) = −aᵀ J a`. At the end of the step the same with the momentum weights `w_i`:
//!
//! ```text
//!     π = I ((ω + h⁻¹ Σ_i w_i (s_i − h c_i ω)) cos φ_s + h⁻¹ Σ_i w_i v_i sin φ_s) + h b_s m (…)       [kg m²/s]
//! ```

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::Arithmetic;
use crate::stages::pose::StagePose;
use crate::stages::rows::Rows;
use crate::stages::start::Pivot;

/// Sine and versine of the turn of a body about an axis.
#[inline(always)]
pub fn turned_about<V: Arithmetic>(pose: &StagePose<V>, axis: &[V::Real; 3]) -> [V; 2] {
    let half = pose.u.dot(Vector::splat(axis));
    let twice = half + half;
    [pose.w * twice, half * twice]
}

/// `e` of a body about its axis; for momenta `−π`.
#[inline(always)]
pub fn pivot_torque<V: Arithmetic, R: Rows<V>>(
    rows: &R,
    body: usize,
    known: &Pivot<V::Real>,
    axis: &[V::Real; 3],
    rate: V::Real,
) -> V {
    let turned = turned_about(&rows.pose(body), axis);
    let [sines, versines] = rows.swing(body, axis, rate, turned);
    // The code below has the geometry of the rows.
    let [sine, versine] = [turned[0] * rows.moved(), turned[1] * rows.moved()];
    let cosine = V::splat(1.0) - versine;
    let moment = V::whole(known.inertia) * versines.mul_add(sine, sines * cosine);
    let [now, later] = known.weights.map(V::whole);
    let weight = later.mul_add(sine, now * cosine);
    weight.neg_mul_add(rows.forces(), if R::MOMENTA { -moment } else { moment })
}

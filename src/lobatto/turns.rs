//! Rotations as unit quaternions `(w, u)`, for all stages at once: their series, their product, and what they do to a vector.
//!
//! ```text
//!     w = cos φ/2 = Σ_n (−φ²/4)ⁿ / (2n)!           u = θ sin(φ/2)/φ,   sin(φ/2)/φ = ½ Σ_n (−φ²/4)ⁿ / (2n + 1)!        φ = |θ|  (rad)
//!     (w, u) ∘ (w₂, u₂) = (w w₂ − u·u₂, w u₂ + w₂ u + u × u₂)
//!     N v = R v − v = 2 (w u × v + u × (u × v))
//!     1 − k₁ θ̂ + k₂ θ̂²,   k₁ = (1 − cos φ)/φ²,   k₂ = (φ − sin φ)/φ³       the tangent of the exponential map
//! ```

use super::algebra::Vector;
use super::lanes::Lanes;
use super::numbers::Arithmetic;

/// `N v = (D − 1) v` of a rotation given as a unit quaternion, without cancellation.
#[inline(always)]
pub fn rotate_increment<V: Arithmetic>(w: V, u: Vector<V>, v: Vector<V>) -> Vector<V> {
    let twice = u.times(V::splat(2.0));
    let across = twice.cross(v);
    u.cross_plus(across, across.times(w))
}

/// The product of two quaternions.
#[inline(always)]
pub(super) fn compose<V: Arithmetic>(w: V, u: Vector<V>, w2: V, u2: Vector<V>) -> (V, Vector<V>) {
    let real = u.dot_from(u2, w * w2);
    (real, u.cross_plus(u2, u2.times_plus(w, u.times(w2))))
}

/// `(−1/4)ⁿ / (2n)!`, the series of `cos(φ/2)` in `φ²`,
const COSINE: [f64; 11] = series(0, 1.0);
/// and `½ (−1/4)ⁿ / (2n + 1)!`, that of `sin(φ/2)/φ`.
const SINE: [f64; 11] = series(1, 0.5);

/// `cos(φ/2)` and `sin(φ/2)/φ` from `φ²`, for `φ ≤` [`MAX_TURN`](super::stage::MAX_TURN), by their Taylor series.
#[inline(always)]
pub(super) fn half_angle<V: Lanes>(square: V) -> (V, V) {
    // At φ = 3.1 the first term left out is below 2e-17.
    (polynomial(&COSINE, square), polynomial(&SINE, square))
}

/// Up to this angle (rad) [`half_angle_of_few`] is enough.
pub(super) const FEW: f64 = 0.75;

/// A rotation vector whose components are all up to this part of an angle is not longer than that angle: a little less than 1/√3.
pub(super) const EACH: f64 = 0.57;

/// [`half_angle`] for `φ ≤` [`FEW`]: at 0.75 the first term left out is below 2e-17.
#[inline(always)]
pub(super) fn half_angle_of_few<V: Lanes>(square: V) -> (V, V) {
    (horner(&COSINE[..7], square), horner(&SINE[..7], square))
}

/// [`half_angle`] to seven digits.
#[inline(always)]
pub(super) fn half_angle_single<V: Arithmetic>(square: V, few: bool) -> (V, V) {
    if few {
        (horner(&COSINE[..5], square), horner(&SINE[..4], square))
    } else {
        (horner(&COSINE[..8], square), horner(&SINE[..8], square))
    }
}

/// The coefficients `first · (−1/4)ⁿ / (2n + odd)!`.
const fn series(odd: usize, first: f64) -> [f64; 11] {
    let mut terms = [first; 11];
    let mut n = 1;
    while n < terms.len() {
        terms[n] = -0.25 * terms[n - 1] / (((2 * n + odd) * (2 * n + odd - 1)) as f64);
        n += 1;
    }
    terms
}

/// How a rotation vector `θ` of a ball joint tilts its free axes, in the axes of the start: `(1 − k₁ θ̂ + k₂ θ̂²) axis`.
#[derive(Clone, Copy)]
pub struct Tilt<V> {
    vector: Vector<V>,
    coefficients: (V, V),
}

impl<V: Arithmetic> Tilt<V> {
    /// That of a rotation vector.
    #[inline(always)]
    pub fn of(vector: Vector<V>) -> Self {
        Tilt { vector, coefficients: tangent(vector.dot(vector)) }
    }

    /// An axis, tilted.
    #[inline(always)]
    pub fn of_axis(&self, axis: Vector<V>) -> Vector<V> {
        let (first, second) = self.coefficients;
        let once = self.vector.cross(axis);
        self.vector.cross(once).times_plus(second, once.times_minus(first, axis))
    }
}

/// An axis of a ball joint, tilted if it is. Written out, because closures over vectors are not inlined.
#[inline(always)]
pub(super) fn tilted_by<V: Arithmetic>(tilt: Option<Tilt<V>>, axis: Vector<V>) -> Vector<V> {
    match tilt {
        Some(tilt) => tilt.of_axis(axis),
        None => axis,
    }
}

/// What a change of a rotation vector `θ` has to be for one of the rotation, in the axes of the start:
///
/// ```text
///     (1 − k₁ θ̂ + k₂ θ̂²)⁻¹ v = (1 + ½ θ̂ + κ θ̂²) v,     κ = (1 − φ/2 cot φ/2)/φ² = 1/12 + φ²/720 + φ⁴/30240 + …
/// ```
///
/// to a thousandth at half a turn, which is enough for a Newton step.
#[inline(always)]
pub(super) fn untilted<V: Arithmetic>(vector: Vector<V>, v: Vector<V>) -> Vector<V> {
    const TERMS: [f64; 5] = [1.0 / 12.0, 1.0 / 720.0, 1.0 / 30_240.0, 1.0 / 1_209_600.0, 1.0 / 47_900_160.0];
    let once = vector.cross(v);
    let twice = vector.cross(once);
    twice.times_plus(horner(&TERMS, vector.dot(vector)), once.times_plus(V::splat(0.5), v))
}

/// `(1 − cos φ)/φ²` and `(φ − sin φ)/φ³` from `φ²`: the coefficients of the tangent of the exponential map. They span the projection, steer
/// the Newton step, and give ball joints with forces their spin; at 3.1 rad the first term left out is below 2e-17.
#[inline(always)]
fn tangent<V: Arithmetic>(square: V) -> (V, V) {
    const FIRST: [f64; 13] = tangent_series(2);
    const SECOND: [f64; 13] = tangent_series(3);
    (polynomial(&FIRST, square), polynomial(&SECOND, square))
}

/// `(−1)ⁿ / (2n + first)!`.
const fn tangent_series(first: usize) -> [f64; 13] {
    let mut terms = [if first == 2 { 0.5 } else { 1.0 / 6.0 }; 13];
    let mut n = 1;
    while n < terms.len() {
        terms[n] = -terms[n - 1] / (((2 * n + first) * (2 * n + first - 1)) as f64);
        n += 1;
    }
    terms
}

/// A polynomial of many terms, with ascending coefficients: `c₀ + x ((c₁ + c₃ x² + …) + x (c₂ + c₄ x² + …))`, two chains of half the length for
/// those who wait for it.
#[inline(always)]
pub fn polynomial<V: Arithmetic>(coefficients: &[f64], x: V) -> V {
    let square = x * x;
    let last = coefficients.len() - 1;
    let mut chains = [V::splat(coefficients[last]), V::splat(coefficients[last - 1])];
    let mut index = last - 1;
    while index > 1 {
        index -= 1;
        let chain = (last - index) % 2;
        chains[chain] = chains[chain].mul_add(square, V::splat(coefficients[index]));
    }
    // The chain of an even number of terms ends with c₁, the other one with c₂.
    let (odd, even) = if last % 2 == 1 { (chains[0], chains[1]) } else { (chains[1], chains[0]) };
    even.mul_add(x, odd).mul_add(x, V::splat(coefficients[0]))
}

/// A polynomial of few terms, with ascending coefficients.
#[inline(always)]
pub fn horner<V: Arithmetic>(coefficients: &[f64], x: V) -> V {
    let mut value = V::splat(coefficients[coefficients.len() - 1]);
    let mut index = coefficients.len() - 1;
    while index > 0 {
        index -= 1;
        value = value.mul_add(x, V::splat(coefficients[index]));
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobatto::lanes::Portable;

    #[test]
    fn two_chains_add_up_to_the_polynomial_whatever_the_number_of_terms() {
        let terms: Vec<f64> = (0..16).map(|n| (1.0 + 3.0 * n as f64).sin()).collect();
        for count in 3..=terms.len() {
            let x = Portable::<4>::from_slice(&[0.7, -1.1, 0.0, 1.3]);
            let two = polynomial(&terms[..count], x).to_array();
            let one = horner(&terms[..count], x).to_array();
            for (two, one) in two.iter().zip(one) {
                // Some roundings of sums of sixteen terms of up to 50.
                assert!((two - one).abs() < 1e-13, "{count} terms: {two} and {one}");
            }
        }
    }
}

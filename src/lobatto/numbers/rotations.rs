//! Rotations as unit quaternions `(w, u)`, for all stages at once: their series, their product, and the rotation of a vector.
//!
//! ```text
//!     w = cos φ/2 = Σ_n (−φ²/4)ⁿ / (2n)!           u = θ sin(φ/2)/φ,   sin(φ/2)/φ = ½ Σ_n (−φ²/4)ⁿ / (2n + 1)!        φ = |θ|  (rad)
//!     (w, u) ∘ (w₂, u₂) = (w w₂ − u·u₂, w u₂ + w₂ u + u × u₂)
//!     N v = R v − v = 2 (w u × v + u × (u × v))
//!     1 − k₁ θ̂ + k₂ θ̂²,   k₁ = (1 − cos φ)/φ²,   k₂ = (φ − sin φ)/φ³       the tangent of the exponential map
//! ```

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::Arithmetic;
use crate::numbers::series::{horner, polynomial};

/// `N v = (D − 1) v` of a rotation given as a unit quaternion, without cancellation.
#[inline(always)]
pub fn rotate_increment<V: Arithmetic>(w: V, u: Vector<V>, v: Vector<V>) -> Vector<V> {
    let twice = u.times(V::splat(2.0));
    let across = twice.cross(v);
    u.cross_plus(across, across.times(w))
}

/// The product of two quaternions.
#[inline(always)]
pub(crate) fn compose<V: Arithmetic>(w: V, u: Vector<V>, w2: V, u2: Vector<V>) -> (V, Vector<V>) {
    let real = u.dot_from(u2, w * w2);
    (real, u.cross_plus(u2, u2.times_plus(w, u.times(w2))))
}

/// A rotation vector whose components are all up to this part of an angle is not longer than that angle: a little less than 1/√3.
pub(crate) const EACH: f64 = 0.57;

/// How a rotation vector `θ` of a ball joint tilts its free axes, in the axes of the start: `(1 − k₁ θ̂ + k₂ θ̂²) axis`.
#[derive(Clone, Copy)]
pub struct Tilt<V> {
    vector: Vector<V>,
    coefficients: (V, V),
}

impl<V: Arithmetic> Tilt<V> {
    /// The rotation of a rotation vector.
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
pub(crate) fn tilted_by<V: Arithmetic>(tilt: Option<Tilt<V>>, axis: Vector<V>) -> Vector<V> {
    match tilt {
        Some(tilt) => tilt.of_axis(axis),
        None => axis,
    }
}

/// The change of a rotation vector `θ` that corresponds to a change of the rotation, in the axes of the start:
///
/// ```text
///     (1 − k₁ θ̂ + k₂ θ̂²)⁻¹ v = (1 + ½ θ̂ + κ θ̂²) v,     κ = (1 − φ/2 cot φ/2)/φ² = 1/12 + φ²/720 + φ⁴/30240 + …
/// ```
///
/// to a thousandth at half a turn, which is enough for a Newton step.
#[inline(always)]
pub(crate) fn untilted<V: Arithmetic>(vector: Vector<V>, v: Vector<V>) -> Vector<V> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::lanes::Lanes;
    use crate::vectors::portable::Portable;

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

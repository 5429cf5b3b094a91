//! Power series of the half angle of a rotation, and polynomials.
//!
//! ```text
//!     cos φ/2 = Σ_n (−φ²/4)ⁿ / (2n)!           sin(φ/2)/φ = ½ Σ_n (−φ²/4)ⁿ / (2n + 1)!        φ (rad)
//! ```

use crate::numbers::arithmetic::Arithmetic;

/// `(−1/4)ⁿ / (2n)!`, the series of `cos(φ/2)` in `φ²`.
const COSINE: [f64; 11] = series(0, 1.0);
/// `½ (−1/4)ⁿ / (2n + 1)!`, the series of `sin(φ/2)/φ` in `φ²`.
const SINE: [f64; 11] = series(1, 0.5);

/// `cos(φ/2)` and `sin(φ/2)/φ` from `φ²`, for `φ ≤` [`MAX_TURN`](crate::stages::pose::MAX_TURN), by their Taylor series.
#[inline(always)]
pub(crate) fn half_angle<V: Arithmetic>(square: V) -> (V, V) {
    // At φ = 3.1 the first term left out is below 2e-17.
    (polynomial(&COSINE, square), polynomial(&SINE, square))
}

/// Up to this angle (rad) [`half_angle_of_few`] is enough.
pub(crate) const FEW: f64 = 0.75;

/// [`half_angle`] for `φ ≤` [`FEW`]: at 0.75 the first term left out is below 2e-17.
#[inline(always)]
pub(crate) fn half_angle_of_few<V: Arithmetic>(square: V) -> (V, V) {
    (horner(&COSINE[..7], square), horner(&SINE[..7], square))
}

/// [`half_angle`] to seven digits.
#[inline(always)]
pub(crate) fn half_angle_single<V: Arithmetic>(square: V, few: bool) -> (V, V) {
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

/// A polynomial of many terms, with ascending coefficients: `c₀ + x ((c₁ + c₃ x² + …) + x (c₂ + c₄ x² + …))`, two chains of half the length, for code
/// that waits for the result.
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

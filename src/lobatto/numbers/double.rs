//! Lanes of numbers with 32 digits: pairs of vectors.
//!
//! ```text
//!     value = high + low,   |low| ≤ ½ ulp(high)
//!     a + b:   s = a.high + b.high, its lost part (Knuth) + a.low + b.low
//!     a · b:   p = a.high · b.high, its lost part (fused multiply-add) + a.high b.low + a.low b.high
//! ```
//!
//! The error of a sum is some 2⁻¹⁰⁵ ≈ 2e-32 of the larger operand, not of the sum: cancellation has lost those digits before, as in any sum of
//! doubles. Source: T. J. Dekker, Numerische Mathematik 18 (1971); Y. Hida, X. Li and D. Bailey, ARITH-15 (2001), section 3.

use crate::numbers::arithmetic::{Arithmetic, InLines, Numbers};
use crate::numbers::extended::Extended;
use crate::numbers::lanes::Lanes;
use std::ops::{Add, Mul, Neg, Sub};
use std::sync::LazyLock;

/// A number of 32 digits in every lane.
#[derive(Clone, Copy)]
pub struct Double<V> {
    high: V,
    low: V,
}

impl<V: Lanes> Double<V> {
    /// Numbers of sixteen digits.
    #[inline(always)]
    pub fn widened(high: V) -> Self {
        Double { high, low: V::zero() }
    }

    /// The same to sixteen digits.
    #[inline(always)]
    pub fn rounded(self) -> V {
        self.high
    }

    /// The sum of a leading part and a smaller one.
    #[inline(always)]
    fn normalised(high: V, low: V) -> Self {
        let sum = high + low;
        Double { high: sum, low: low - (sum - high) }
    }
}

/// Runs an operation in a function of its own: a sweep with all of them in place would take the compiler a quarter of an hour.
macro_rules! apart {
    ($vector:ty, $work:expr) => {
        <$vector>::apart(
            #[inline(always)]
            || $work,
        )
    };
}

/// `a + b`.
#[inline(always)]
fn sum<V: Lanes>(a: Double<V>, b: Double<V>) -> Double<V> {
    let sum = a.high + b.high;
    let of_b = sum - a.high;
    let lost = (a.high - (sum - of_b)) + (b.high - of_b);
    Double::normalised(sum, lost + (a.low + b.low))
}

/// `a · b`.
#[inline(always)]
fn product<V: Lanes>(a: Double<V>, b: Double<V>) -> Double<V> {
    let product = a.high * b.high;
    let lost = a.high.lost(b.high, product);
    Double::normalised(product, a.high.mul_add(b.low, a.low.mul_add(b.high, lost)))
}

impl<V: Lanes> Add for Double<V> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        apart!(V, sum(self, other))
    }
}

impl<V: Lanes> Sub for Double<V> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        apart!(V, sum(self, -other))
    }
}

impl<V: Lanes> Neg for Double<V> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Double { high: -self.high, low: -self.low }
    }
}

impl<V: Lanes> Mul for Double<V> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        apart!(V, product(self, other))
    }
}

impl<V: Lanes> Arithmetic for Double<V> {
    type Real = Extended;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self::widened(V::splat(value))
    }
    #[inline(always)]
    fn whole(value: Extended) -> Self {
        Double { high: V::splat(value.rounded()), low: V::splat(value.remainder()) }
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> Extended {
        Extended::from_parts(self.high.to_array().as_ref()[lane], self.low.to_array().as_ref()[lane])
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        apart!(V, sum(product(self, b), c))
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        apart!(V, sum(product(-self, b), c))
    }
    #[inline(always)]
    fn lost(self, _: Self, _: Self) -> Self {
        Self::zero()
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        // One step of Newton's method from the reciprocal of sixteen digits.
        apart!(V, {
            let first = self.high.reciprocal();
            let product = first * self.high;
            let error = (V::splat(1.0) - product) - first.lost(self.high, product) - first * self.low;
            Self::normalised(first, first * error)
        })
    }
}

impl<V: Lanes> Numbers for Double<V> {
    type One = Self;
    fn real(value: f64) -> Extended {
        Extended::from(value)
    }
    fn from_parts(high: &[f64], low: &[f64]) -> Self {
        Double { high: V::from_slice(high), low: V::from_slice(low) }
    }
    #[inline(always)]
    fn mix(self, columns: &[Self]) -> Self {
        apart!(V, {
            let (high, low) = (self.high.to_array(), self.low.to_array());
            let lane =
                |index: usize| Double { high: V::splat(high.as_ref()[index]), low: V::splat(low.as_ref()[index]) };
            let mut mixed = product(columns[0], lane(0));
            let mut index = 1;
            while index < V::COUNT {
                mixed = sum(mixed, product(columns[index], lane(index)));
                index += 1;
            }
            mixed
        })
    }
    const STORES_EARLY: bool = false;
    type Stored = Self;
    fn store_all<const N: usize>(values: [Self; N]) -> InLines<Self, N> {
        InLines(values)
    }
    fn mix_stored<const N: usize>(InLines(values): &InLines<Self, N>, columns: &[Self]) -> [Self; N] {
        Self::mix_all(*values, columns)
    }
    #[inline(always)]
    fn weigh_all<const N: usize>(values: [Self; N], weights: &[Self]) -> [Self; N] {
        Self::mix_all(values, weights)
    }
    #[inline(always)]
    fn max_abs(self, bound: Self) -> Self {
        Self::widened(self.high.max_abs(bound.high))
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        self.high.largest()
    }
    #[inline(always)]
    fn half_angle(square: Self, _: bool) -> (Self, Self) {
        let [cosine, sine] = &*HALF_ANGLE;
        apart!(V, (horner(cosine, square), horner(sine, square)))
    }
}

/// Terms of the series of sine and cosine: at 3.1 rad the first term left out is below 1e-34.
const TERMS: usize = 18;

/// (−1/4)ⁿ/(2n)! and ½ (−1/4)ⁿ/(2n+1)!, of cos(φ/2) and sin(φ/2)/φ.
static HALF_ANGLE: LazyLock<[[Extended; TERMS]; 2]> = LazyLock::new(|| {
    [(0, 1.0), (1, 0.5)].map(|(odd, first)| {
        let mut term = Extended::from(first);
        std::array::from_fn(|n| {
            if n > 0 {
                term = -term / Extended::from(4 * (2 * n + odd) * (2 * n + odd - 1));
            }
            term
        })
    })
});

/// A polynomial with ascending coefficients.
#[inline(always)]
fn horner<V: Lanes>(coefficients: &[Extended; TERMS], x: Double<V>) -> Double<V> {
    let mut value = Double::whole(coefficients[TERMS - 1]);
    let mut index = TERMS - 1;
    while index > 0 {
        index -= 1;
        value = sum(product(value, x), Double::whole(coefficients[index]));
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vectors::portable::Portable;

    /// Each operation in every lane beside [`Extended`], whose arithmetic was written for one number at a time.
    fn operations_are_good_to_thirty_digits<V: Lanes>() {
        let third = |n: usize| Extended::from(n) / Extended::from(3.0);
        let long = |n: usize| Double::<V>::whole(third(n));
        let close = |name: &str, got: Double<V>, wanted: Extended| {
            for lane in 0..V::COUNT {
                let off = (got.lane(lane) - wanted).rounded().abs();
                assert!(off < 1e-30 * wanted.rounded().abs().max(1.0), "{name}, lane {lane}: off by {off:.1e}");
            }
        };
        V::run(|| {
            close("sum", long(7) + long(5), third(12));
            close("difference that cancels", long(7) - long(6), third(1));
            close("product", long(7) * long(5), third(7) * third(5));
            close("product and sum", long(7).mul_add(long(5), long(2)), third(7) * third(5) + third(2));
            close("less a product", long(7).neg_mul_add(long(5), long(2)), third(2) - third(7) * third(5));
            close("reciprocal", long(7).reciprocal(), Extended::ONE / third(7));
            let columns: Vec<Double<V>> = (0..V::COUNT).map(|column| long(column + 1)).collect();
            let all = (0..V::COUNT).map(|column| third(column + 1) * third(4)).sum();
            close("mixed lanes", long(4).mix(&columns), all);
            // cos² + sin² = 1 at the largest turn, and the half angle of a turn of π/3 whose cosine is known: cos²(π/6) = 3/4.
            let (cosine, sine) = Double::<V>::half_angle(long(28), false);
            close("circle", cosine * cosine + sine * sine * long(28), Extended::ONE);
            let turn = Double::<V>::splat(std::f64::consts::FRAC_PI_3) - Double::splat(1.072_081_766_451_091e-16);
            let (cosine, _) = Double::<V>::half_angle(turn * turn, false);
            close("cos² π/6", cosine * cosine, third(9) / Extended::from(4.0));
        });
    }

    #[test]
    fn operations_are_good_to_thirty_digits_in_every_vector_the_processor_has() {
        operations_are_good_to_thirty_digits::<Portable<8>>();
        #[cfg(target_arch = "x86_64")]
        {
            use crate::numbers::lanes::Isa;
            use crate::vectors::pair::Pair;
            use crate::vectors::x86::{Avx256, Avx512};
            if Isa::detect() != Isa::Portable {
                operations_are_good_to_thirty_digits::<Pair<Avx256, 8>>();
            }
            if Isa::detect() == Isa::Avx512 {
                operations_are_good_to_thirty_digits::<Avx512>();
            }
        }
    }
}

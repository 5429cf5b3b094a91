//! A number of about 32 digits: the unevaluated sum of two doubles, for the coefficients that are computed at start-up and for the start of steps of
//! 32 digits. Many of them at once, in lanes, are [`crate::numbers::double::Double`].
//!
//! ```text
//!     value = high + low,   |low| ≤ ½ ulp(high)        so that `high` is the value correctly rounded to a double
//! ```
//!
//! Every operation is exact up to a relative error of a few 2⁻¹⁰⁴ ≈ 5e-32. Source: T. J. Dekker, "A floating-point technique for extending the
//! available precision", Numerische Mathematik 18 (1971); the names two-sum and two-product are from the later literature.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number held as the sum of two doubles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extended {
    /// The value rounded to a double.
    high: f64,
    /// The rounding error of `high`.
    low: f64,
}

/// The rounded sum of two doubles and its exact rounding error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part_of_b = sum - a;
    (sum, (a - (sum - part_of_b)) + (b - part_of_b))
}

/// The rounded product of two doubles and its exact rounding error.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl Extended {
    /// Zero.
    pub(crate) const ZERO: Extended = Extended { high: 0.0, low: 0.0 };
    /// One.
    pub(crate) const ONE: Extended = Extended { high: 1.0, low: 0.0 };

    /// The sum of a leading part and a smaller one.
    pub(crate) fn from_parts(high: f64, low: f64) -> Self {
        let sum = high + low;
        Extended { high: sum, low: low - (sum - high) }
    }

    /// The value correctly rounded to a double.
    pub(crate) fn rounded(self) -> f64 {
        self.high
    }

    /// The rounding error of rounding to a double, itself rounded.
    pub(crate) fn remainder(self) -> f64 {
        self.low
    }

    /// The absolute value.
    #[cfg(test)]
    pub(crate) fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }
}

impl From<f64> for Extended {
    fn from(value: f64) -> Self {
        Extended { high: value, low: 0.0 }
    }
}

impl From<usize> for Extended {
    /// Exact for every integer below 2⁵³.
    fn from(value: usize) -> Self {
        Extended { high: value as f64, low: 0.0 }
    }
}

impl Neg for Extended {
    type Output = Extended;
    fn neg(self) -> Extended {
        Extended { high: -self.high, low: -self.low }
    }
}

impl Add for Extended {
    type Output = Extended;
    fn add(self, other: Extended) -> Extended {
        let (sum, error) = two_sum(self.high, other.high);
        // The low parts are added exactly too: dropping their error would lose all digits in a cancellation.
        let (low, low_error) = two_sum(self.low, other.low);
        let partial = Extended::from_parts(sum, error + low);
        Extended::from_parts(partial.high, partial.low + low_error)
    }
}

impl Sub for Extended {
    type Output = Extended;
    fn sub(self, other: Extended) -> Extended {
        self + -other
    }
}

impl Mul for Extended {
    type Output = Extended;
    fn mul(self, other: Extended) -> Extended {
        let (product, error) = two_product(self.high, other.high);
        Extended::from_parts(product, error + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Extended {
    type Output = Extended;
    fn div(self, other: Extended) -> Extended {
        let first = self.high / other.high;
        let remainder = self - other * Extended::from(first);
        let second = remainder.high / other.high;
        let remainder = remainder - other * Extended::from(second);
        let third = remainder.high / other.high;
        Extended::from_parts(first, second) + Extended::from(third)
    }
}

impl std::iter::Sum for Extended {
    fn sum<I: Iterator<Item = Extended>>(terms: I) -> Extended {
        terms.fold(Extended::ZERO, Add::add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_carries_thirty_digits() {
        // 1/3 · 3 − 1 and (1 + 2⁻⁸⁰)² − 1 − 2⁻⁷⁹ = 2⁻¹⁶⁰ are zero to thirty digits; a double alone leaves 1e-16 and 1e-24.
        let third = Extended::ONE / Extended::from(3.0);
        assert!((third * Extended::from(3.0) - Extended::ONE).abs().rounded() < 1e-31);
        let tiny = Extended::from(2f64.powi(-80));
        let square = (Extended::ONE + tiny) * (Extended::ONE + tiny);
        assert!((square - Extended::ONE - tiny - tiny).abs().rounded() < 1e-31);
        assert_eq!((square - Extended::ONE).rounded(), 2f64.powi(-79));
    }
}

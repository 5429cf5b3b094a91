//! A number with its derivatives by N parameters, to the last digit: no differences.
//!
//! ```text
//!     (a, a') (b, b') = (a b, a' b + a b')        f(a, a') = (f(a), f'(a) a')
//! ```
//!
//! Source: A. Griewank, A. Walther, Evaluating Derivatives, SIAM 2008, chapter 3.

use crate::derivatives::numbers::number::Number;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value and its derivatives by N parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// The derivatives.
    pub parts: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// A parameter: the derivative by itself is one.
    pub fn parameter(value: f64, index: usize) -> Self {
        let mut parts = [0.0; N];
        parts[index] = 1.0;
        Dual { value, parts }
    }

    /// A function with this value and slope.
    #[inline(always)]
    fn through(self, value: f64, slope: f64) -> Self {
        let mut parts = [0.0; N];
        for index in 0..N {
            parts[index] = slope * self.parts[index];
        }
        Dual { value, parts }
    }

    #[inline(always)]
    fn with(self, other: Self, value: f64, of: impl Fn(f64, f64) -> f64) -> Self {
        let mut parts = [0.0; N];
        for index in 0..N {
            parts[index] = of(self.parts[index], other.parts[index]);
        }
        Dual { value, parts }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, self.value + other.value, |own, other| own + other)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, self.value - other.value, |own, other| own - other)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    // The derivative of a product is a sum.
    #[expect(clippy::suspicious_arithmetic_impl)]
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, self.value * other.value, |own, others| other.value * own + self.value * others)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        let inverse = 1.0 / other.value;
        self.with(other, quotient, |own, other| inverse * (own - quotient * other))
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.through(-self.value, -1.0)
    }
}

impl<const N: usize> Number for Dual<N> {
    #[inline(always)]
    fn of(value: f64) -> Self {
        Dual { value, parts: [0.0; N] }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        let root = self.value.sqrt();
        self.through(root, 0.5 / root)
    }

    #[inline(always)]
    fn sine_cosine(self) -> (Self, Self) {
        let (sine, cosine) = self.value.sin_cos();
        (self.through(sine, cosine), self.through(cosine, -sine))
    }

    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        self.through(self.value * factor, factor)
    }
}

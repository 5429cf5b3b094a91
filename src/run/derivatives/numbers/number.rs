//! Numbers for which the equations of motion are written: doubles, and doubles with derivatives.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number with the arithmetic that mechanics needs.
pub trait Number:
    Copy + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A constant.
    fn of(value: f64) -> Self;
    /// The double that it is without its derivatives.
    fn value(self) -> f64;
    /// Its square root.
    fn square_root(self) -> Self;
    /// Its sine and cosine.
    fn sine_cosine(self) -> (Self, Self);

    /// Zero.
    #[inline]
    fn zero() -> Self {
        Self::of(0.0)
    }

    /// Times a double.
    #[inline]
    fn times(self, factor: f64) -> Self {
        self * Self::of(factor)
    }
}

impl Number for f64 {
    #[inline]
    fn of(value: f64) -> Self {
        value
    }

    #[inline]
    fn value(self) -> f64 {
        self
    }

    #[inline]
    fn square_root(self) -> Self {
        self.sqrt()
    }

    #[inline]
    fn sine_cosine(self) -> (Self, Self) {
        self.sin_cos()
    }
}

//! Numbers in which a smooth function is written once: for its value, with its derivatives in time, or at many instants at once.
//!
//! ```text
//!     x = (x, ẋ, ẍ):     (x y)˙ = ẋ y + x ẏ          (x y)˙˙ = ẍ y + 2 ẋ ẏ + x ÿ
//!                        (√x)˙ = ẋ / 2√x             (√x)˙˙ = (ẍ/2 − (√x)˙²) / √x
//!                        (1/x)˙ = −ẋ/x²              (1/x)˙˙ = (2 ẋ²/x − ẍ) / x²
//! ```
//!
//! Source: A. Griewank, A. Walther, Evaluating Derivatives (2008), chapter 13 (Taylor arithmetic).

use std::ops::{Add, Mul, Sub};

/// A number with the arithmetic of smooth functions.
pub trait Smooth: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// A number that is the same always.
    fn constant(value: f64) -> Self;
    /// `√self`.
    fn square_root(self) -> Self;
    /// `1 / self`.
    fn reciprocal(self) -> Self;
    /// The same number, held: without its derivatives.
    fn held(self) -> Self;
    /// Whether its value is between −bound and bound, at all its instants; never if it is not a number.
    fn is_within(self, bound: f64) -> bool;
}

impl Smooth for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn square_root(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        1.0 / self
    }
    #[inline(always)]
    fn held(self) -> Self {
        self
    }
    #[inline(always)]
    fn is_within(self, bound: f64) -> bool {
        self.abs() <= bound
    }
}

/// A number with its first and second derivatives in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet {
    /// x.
    pub value: f64,
    /// ẋ.
    pub rate: f64,
    /// ẍ.
    pub second: f64,
}

impl Add for Jet {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Jet { value: self.value + other.value, rate: self.rate + other.rate, second: self.second + other.second }
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Jet { value: self.value - other.value, rate: self.rate - other.rate, second: self.second - other.second }
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Jet {
            value: self.value * other.value,
            rate: self.rate * other.value + self.value * other.rate,
            second: self.second * other.value + 2.0 * self.rate * other.rate + self.value * other.second,
        }
    }
}

impl Smooth for Jet {
    fn constant(value: f64) -> Self {
        Jet { value, ..Jet::default() }
    }
    fn square_root(self) -> Self {
        let value = self.value.sqrt();
        let rate = 0.5 * self.rate / value;
        Jet { value, rate, second: (0.5 * self.second - rate * rate) / value }
    }
    fn reciprocal(self) -> Self {
        let value = 1.0 / self.value;
        let rate = -self.rate * value * value;
        Jet { value, rate, second: (2.0 * self.rate * self.rate * value - self.second) * value * value }
    }
    fn held(self) -> Self {
        Jet::constant(self.value)
    }
    fn is_within(self, bound: f64) -> bool {
        self.value.is_within(bound)
    }
}

/// A vector of such numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple<S>(pub [S; 3]);

impl<S: Smooth> Triple<S> {
    /// `self + other`.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Triple([a + x, b + y, c + z])
    }
    /// `self − other`.
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Triple([a - x, b - y, c - z])
    }
    /// `self · factor`.
    #[inline(always)]
    pub fn times(self, factor: S) -> Self {
        let [a, b, c] = self.0;
        Triple([a * factor, b * factor, c * factor])
    }
    /// `self · other`.
    #[inline(always)]
    pub fn dot(self, other: Self) -> S {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }
    /// `self × other`.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Triple([b * z - c * y, c * x - a * z, a * y - b * x])
    }
}

//! A number with its first and second derivative by time: positions give velocities and accelerations.
//!
//! ```text
//!     (a b)¨ = ä b + 2 ȧ ḃ + a b̈        f(a)¨ = f''(a) ȧ² + f'(a) ä
//! ```

use crate::derivatives::numbers::number::Number;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value, its rate and its acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<T> {
    /// The value.
    pub value: T,
    /// Its derivative by time [1/s].
    pub rate: T,
    /// Its second derivative by time [1/s²].
    pub acceleration: T,
}

impl<T: Number> Jet<T> {
    /// A function with this value and these two derivatives by its argument.
    #[inline]
    fn through(self, value: T, slope: T, curvature: T) -> Self {
        let Jet { rate, acceleration, .. } = self;
        Jet { value, rate: slope * rate, acceleration: curvature * rate * rate + slope * acceleration }
    }

    #[inline]
    fn reciprocal(self) -> Self {
        let inverse = T::of(1.0) / self.value;
        let square = inverse * inverse;
        self.through(inverse, -square, (square * inverse).times(2.0))
    }
}

impl<T: Number> Add for Jet<T> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Jet {
            value: self.value + other.value,
            rate: self.rate + other.rate,
            acceleration: self.acceleration + other.acceleration,
        }
    }
}

impl<T: Number> Sub for Jet<T> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<T: Number> Mul for Jet<T> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Jet {
            value: self.value * other.value,
            rate: self.rate * other.value + self.value * other.rate,
            acceleration: self.acceleration * other.value
                + (self.rate * other.rate).times(2.0)
                + self.value * other.acceleration,
        }
    }
}

impl<T: Number> Div for Jet<T> {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl)]
    #[inline]
    fn div(self, other: Self) -> Self {
        self * other.reciprocal()
    }
}

impl<T: Number> Neg for Jet<T> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Jet { value: -self.value, rate: -self.rate, acceleration: -self.acceleration }
    }
}

impl<T: Number> Number for Jet<T> {
    #[inline]
    fn of(value: f64) -> Self {
        Jet { value: T::of(value), rate: T::zero(), acceleration: T::zero() }
    }

    #[inline]
    fn value(self) -> f64 {
        self.value.value()
    }

    #[inline]
    fn square_root(self) -> Self {
        let root = self.value.square_root();
        let slope = T::of(0.5) / root;
        self.through(root, slope, -(slope / self.value).times(0.5))
    }

    #[inline]
    fn sine_cosine(self) -> (Self, Self) {
        let (sine, cosine) = self.value.sine_cosine();
        (self.through(sine, cosine, -sine), self.through(cosine, -sine, -cosine))
    }

    #[inline]
    fn times(self, factor: f64) -> Self {
        Jet {
            value: self.value.times(factor),
            rate: self.rate.times(factor),
            acceleration: self.acceleration.times(factor),
        }
    }
}

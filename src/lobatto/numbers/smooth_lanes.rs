//! Lanes as numbers of smooth functions: the mechanism's formulas, written once for a value and for its derivatives, are evaluated at all stages,
//! too.

use crate::numbers::algebra::Vector;
use crate::numbers::lanes::Lanes;
use catena_mechanism::ground::smooth::{Smooth, Triple};
use std::ops::{Add, Mul, Sub};

/// Lanes as numbers of smooth functions.
#[derive(Clone, Copy)]
pub(crate) struct Lane<V>(pub V);

impl<V: Lanes> Add for Lane<V> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Lane(self.0 + other.0)
    }
}

impl<V: Lanes> Sub for Lane<V> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Lane(self.0 - other.0)
    }
}

impl<V: Lanes> Mul for Lane<V> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Lane(self.0 * other.0)
    }
}

impl<V: Lanes> Smooth for Lane<V> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Lane(V::splat(value))
    }
    #[inline(always)]
    fn square_root(self) -> Self {
        Lane(self.0.square_root())
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        Lane(self.0.reciprocal())
    }
    #[inline(always)]
    fn held(self) -> Self {
        self
    }
    #[inline(always)]
    fn is_within(self, bound: f64) -> bool {
        self.0.max_abs(V::zero()).largest() <= bound
    }
}

/// A vector of such numbers.
#[inline(always)]
pub(crate) fn triple<V: Lanes>(Vector([x, y, z]): Vector<V>) -> Triple<Lane<V>> {
    Triple([Lane(x), Lane(y), Lane(z)])
}

/// A vector of the lanes of such numbers.
#[inline(always)]
pub(crate) fn vector<V: Lanes>(Triple([x, y, z]): Triple<Lane<V>>) -> Vector<V> {
    Vector([x.0, y.0, z.0])
}

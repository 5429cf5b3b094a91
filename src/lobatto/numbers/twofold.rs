//! Two numbers of sixteen digits, one for each of two motions, in the lanes of one vector: the start of a motion differs from lane to lane, while
//! [`Lanes`] have the same start in all of them.

use crate::numbers::arithmetic::Arithmetic;
use crate::numbers::lanes::Lanes;
use std::ops::{Add, Mul, Neg, Sub};

/// One number for each of two motions.
#[derive(Clone, Copy)]
pub struct Twofold<L>(pub(crate) L);

impl<L: Lanes> Add for Twofold<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Twofold(self.0 + other.0)
    }
}

impl<L: Lanes> Sub for Twofold<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Twofold(self.0 - other.0)
    }
}

impl<L: Lanes> Mul for Twofold<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Twofold(self.0 * other.0)
    }
}

impl<L: Lanes> Neg for Twofold<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Twofold(-self.0)
    }
}

impl<L: Lanes<Array = [f64; 2]>> Arithmetic for Twofold<L> {
    type Real = [f64; 2];
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Twofold(<L as Lanes>::splat(value))
    }
    #[inline(always)]
    fn whole(value: [f64; 2]) -> Self {
        Twofold(L::from_array(value))
    }
    #[inline(always)]
    fn lane(self, _: usize) -> [f64; 2] {
        self.0.to_array()
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Twofold(Lanes::mul_add(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Twofold(Lanes::neg_mul_add(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn lost(self, b: Self, product: Self) -> Self {
        Twofold(Lanes::lost(self.0, b.0, product.0))
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        Twofold(Lanes::reciprocal(self.0))
    }
}

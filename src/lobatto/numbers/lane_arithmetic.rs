//! [`Lanes`] as [`Arithmetic`] and [`Numbers`]: doubles, one for each stage.

use crate::numbers::arithmetic::{Arithmetic, InLines, Numbers};
use crate::numbers::lanes::{Lanes, Mixing};
use crate::numbers::mixing::{mix_from_memory, stored};
use crate::numbers::series::{half_angle, half_angle_of_few};
impl<V: Lanes> Arithmetic for V {
    type Real = f64;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        <V as Lanes>::splat(value)
    }
    #[inline(always)]
    fn whole(value: f64) -> Self {
        <V as Lanes>::splat(value)
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.to_array().as_ref()[lane]
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        <V as Lanes>::mul_add(self, b, c)
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        <V as Lanes>::neg_mul_add(self, b, c)
    }
    #[inline(always)]
    fn lost(self, b: Self, product: Self) -> Self {
        <V as Lanes>::lost(self, b, product)
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        <V as Lanes>::reciprocal(self)
    }
}

impl<V: Lanes> Numbers for V {
    type One = <V as Lanes>::One;
    #[inline(always)]
    fn real(value: f64) -> f64 {
        value
    }
    fn from_parts(high: &[f64], _: &[f64]) -> Self {
        V::from_slice(high)
    }
    #[inline(always)]
    fn mix(self, columns: &[Self]) -> Self {
        <V as Lanes>::mix(self, columns)
    }
    #[inline(always)]
    fn mix_all<const N: usize>(values: [Self; N], columns: &[Self]) -> [Self; N] {
        V::Mixing::mix_all(values, columns)
    }
    const STORES_EARLY: bool = <V::Mixing as Mixing<V>>::EARLY;
    type Stored = <V::Mixing as Mixing<V>>::Stored;
    #[inline(always)]
    fn store_all<const N: usize>(values: [Self; N]) -> InLines<Self::Stored, N> {
        V::Mixing::store_all(values)
    }
    #[inline(always)]
    fn mix_stored<const N: usize>(values: &InLines<Self::Stored, N>, columns: &[Self]) -> [Self; N] {
        V::Mixing::mix_stored(values, columns)
    }
    #[inline(always)]
    fn weigh_all<const N: usize>(values: [Self; N], weights: &[Self::One]) -> [Self::One; N] {
        mix_from_memory(&stored(values), weights)
    }
    #[inline(always)]
    fn max_abs(self, bound: Self) -> Self {
        <V as Lanes>::max_abs(self, bound)
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        <V as Lanes>::largest(self)
    }
    #[inline(always)]
    fn half_angle(square: Self, few: bool) -> (Self, Self) {
        if few { half_angle_of_few(square) } else { half_angle(square) }
    }
}

//! Eight stages in single precision, in one register of 256 bits: the arithmetic of [first iterations](crate::solve::single_precision).
//!
//! Its operations are the same with AVX2 and with AVX-512, to the bit.

use crate::numbers::arithmetic::{Arithmetic, InLines, Numbers};
use crate::numbers::mixing::{mix_from_memory, mix_stored_before};
use crate::numbers::series::half_angle_single;
use crate::vectors::x86::Single;
use std::ops::{Add, Mul, Neg, Sub};

operators!(Single,);

impl Arithmetic for Single {
    type Real = f32;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Single::all(value as f32)
    }
    #[inline(always)]
    fn whole(value: f32) -> Self {
        Single::all(value)
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        self.to_array()[lane]
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.fused(b, c)
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        self.fused_from(b, c)
    }
    #[inline(always)]
    fn lost(self, _: Self, _: Self) -> Self {
        Self::zero()
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        Single::all(1.0).over(self)
    }
}

impl Numbers for Single {
    type One = Self;
    #[inline(always)]
    fn real(value: f64) -> f32 {
        value as f32
    }
    fn from_parts(high: &[f64], _: &[f64]) -> Self {
        let mut array = [0.0; 8];
        for (own, &value) in array.iter_mut().zip(high) {
            *own = value as f32;
        }
        Single::from_array(array)
    }
    #[inline(always)]
    fn mix(self, columns: &[Self]) -> Self {
        let [mixed] = Self::mix_all([self], columns);
        mixed
    }
    #[inline(always)]
    fn mix_all<const N: usize>(values: [Self; N], columns: &[Self]) -> [Self; N] {
        mix_from_memory(&Self::store_all(values), columns)
    }
    const STORES_EARLY: bool = true;
    type Stored = [f32; 8];
    #[inline(always)]
    fn store_all<const N: usize>(values: [Self; N]) -> InLines<[f32; 8], N> {
        let mut arrays = InLines([[0.0; 8]; N]);
        let mut value = 0;
        while value < N {
            arrays.0[value] = values[value].to_array();
            value += 1;
        }
        arrays
    }
    #[inline(always)]
    fn mix_stored<const N: usize>(values: &InLines<[f32; 8], N>, columns: &[Self]) -> [Self; N] {
        mix_stored_before(values, columns)
    }
    #[inline(always)]
    fn weigh_all<const N: usize>(values: [Self; N], weights: &[Self]) -> [Self; N] {
        Self::mix_all(values, weights)
    }
    #[inline(always)]
    fn max_abs(self, bound: Self) -> Self {
        self.max_size(bound)
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        let mut bits = 0;
        for lane in self.to_array() {
            bits = lane.to_bits().max(bits);
        }
        f64::from(f32::from_bits(bits))
    }
    #[inline(always)]
    fn half_angle(square: Self, few: bool) -> (Self, Self) {
        half_angle_single(square, few)
    }
}

//! Two vectors as one with twice the lanes, for schemes with more stages than a register has lanes.

use crate::numbers::lanes::Lanes;
use crate::vectors::x86::{Avx256, Avx512, Single, Sse2};
use std::ops::{Add, Mul, Neg, Sub};

/// Twice the lanes of `V`.
#[derive(Clone, Copy)]
pub struct Pair<V, const N: usize>(V, V);

macro_rules! pair {
    ($half:ty, $half_count:literal, $count:literal, { $($own:tt)* }) => {
        impl Pair<$half, $count> {
            #[inline(always)]
            fn lane_add(self, other: Self) -> Self {
                Pair(self.0 + other.0, self.1 + other.1)
            }
            #[inline(always)]
            fn lane_sub(self, other: Self) -> Self {
                Pair(self.0 - other.0, self.1 - other.1)
            }
            #[inline(always)]
            fn lane_mul(self, other: Self) -> Self {
                Pair(self.0 * other.0, self.1 * other.1)
            }
        }
        operators!(Pair<$half, $count>,);
        impl Lanes for Pair<$half, $count> {
            const COUNT: usize = $count;
            type Mixing = <$half as Lanes>::Mixing;
            type Array = [f64; $count];
            type One = <$half as Lanes>::One;
            type Two = <$half as Lanes>::Two;
            $($own)*
            #[inline(always)]
            fn splat(value: f64) -> Self {
                Pair(<$half>::splat(value), <$half>::splat(value))
            }
            #[inline(always)]
            fn from_array(array: [f64; $count]) -> Self {
                Pair(
                    <$half>::from_array(std::array::from_fn(|lane| array[lane])),
                    <$half>::from_array(std::array::from_fn(|lane| array[lane + $half_count])),
                )
            }
            #[inline(always)]
            fn to_array(self) -> [f64; $count] {
                let (low, high) = (self.0.to_array(), self.1.to_array());
                std::array::from_fn(|lane| if lane < $half_count { low[lane] } else { high[lane - $half_count] })
            }
            #[inline(always)]
            fn zero_array() -> [f64; $count] {
                [0.0; $count]
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                Pair(self.0.mul_add(b.0, c.0), self.1.mul_add(b.1, c.1))
            }
            #[inline(always)]
            fn neg_mul_add(self, b: Self, c: Self) -> Self {
                Pair(self.0.neg_mul_add(b.0, c.0), self.1.neg_mul_add(b.1, c.1))
            }
            #[inline(always)]
            fn lost(self, b: Self, product: Self) -> Self {
                Pair(self.0.lost(b.0, product.0), self.1.lost(b.1, product.1))
            }
            #[inline(always)]
            fn reciprocal(self) -> Self {
                Pair(self.0.reciprocal(), self.1.reciprocal())
            }
            #[inline(always)]
            fn max_abs(self, bound: Self) -> Self {
                Pair(self.0.max_abs(bound.0), self.1.max_abs(bound.1))
            }
            #[inline(always)]
            fn sum(self) -> f64 {
                (self.0 + self.1).sum()
            }
            #[inline(always)]
            fn run<R>(work: impl FnOnce() -> R) -> R {
                <$half>::run(work)
            }
            #[inline(always)]
            fn apart<R>(work: impl FnOnce() -> R) -> R {
                <$half>::apart(work)
            }
        }
    };
}

pair!(Sse2, 2, 4, {
    const GENERAL_ALONE: bool = true;
    double_alone!();
});
pair!(Avx256, 4, 8, {
    type Single = Single;
    const HAS_SINGLE: bool = true;
    #[inline(always)]
    fn narrow(self) -> Single {
        Single::from_halves(self.0, self.1)
    }
    #[inline(always)]
    fn widen(single: Single) -> Self {
        let [low, high] = single.halves();
        Pair(low, high)
    }
});
pair!(Avx512, 8, 16, {
    const GENERAL_ALONE: bool = true;
    double_alone!();
});
pair!(Pair<Avx256, 8>, 8, 16, {
    const GENERAL_ALONE: bool = true;
    double_alone!();
});

//! Lanes for every processor: an array, which the compiler puts into the vectors of the target.
//!
//! On x86-64 that is two lanes, for old processors. Up to five stages have vectors of their own there ([`crate::vectors::x86::Sse2`]);
//! sixteen lanes written out in place are a megabyte of instructions a sweep, so that an operation of them is a call.

use crate::numbers::lanes::Lanes;
use std::ops::{Add, Mul, Neg, Sub};

/// `N` lanes in an array.
#[derive(Clone, Copy)]
pub struct Portable<const N: usize>([f64; N]);

impl<const N: usize> Portable<N> {
    /// Whether an operation is a call.
    const CALLED: bool = cfg!(target_arch = "x86_64") && N > 4;

    #[inline(always)]
    fn zip(self, other: Self, operation: impl Fn(f64, f64) -> f64) -> Self {
        self.zip3(other, self, |a, b, _| operation(a, b))
    }
    #[inline(always)]
    fn zip3(self, b: Self, c: Self, operation: impl Fn(f64, f64, f64) -> f64) -> Self {
        if Self::CALLED { Self::zip3_called(&self, &b, &c, operation) } else { self.zip3_in_place(b, c, operation) }
    }
    /// The operands are references, because copies of them would be most of the instructions at a call.
    #[inline(never)]
    fn zip3_called(a: &Self, b: &Self, c: &Self, operation: impl Fn(f64, f64, f64) -> f64) -> Self {
        a.zip3_in_place(*b, *c, operation)
    }
    #[inline(always)]
    fn zip3_in_place(self, b: Self, c: Self, operation: impl Fn(f64, f64, f64) -> f64) -> Self {
        Portable(std::array::from_fn(|lane| operation(self.0[lane], b.0[lane], c.0[lane])))
    }
    #[inline(always)]
    fn lane_add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn lane_sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn lane_mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

operators!(Portable<N>, const N: usize);

impl<const N: usize> Lanes for Portable<N>
where
    [f64; N]: AsRef<[f64]> + AsMut<[f64]>,
{
    const COUNT: usize = N;
    const GENERAL_ALONE: bool = Self::CALLED;
    type Mixing = crate::numbers::mixing::Shuffled;
    type Array = [f64; N];
    type One = Portable<1>;
    type Two = Portable<2>;
    double_alone!();
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Portable([value; N])
    }
    #[inline(always)]
    fn from_array(array: [f64; N]) -> Self {
        Portable(array)
    }
    #[inline(always)]
    fn to_array(self) -> [f64; N] {
        self.0
    }
    #[inline(always)]
    fn zero_array() -> [f64; N] {
        [0.0; N]
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.zip3(b, c, |a, b, c| a * b + c)
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        self.zip3(b, c, |a, b, c| c - a * b)
    }
    #[inline(always)]
    fn lost(self, b: Self, product: Self) -> Self {
        // Slow where the processor cannot, but right.
        self.zip3(b, product, |a, b, product| a.mul_add(b, -product))
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        Portable(self.0.map(|value| 1.0 / value))
    }
    #[inline(always)]
    fn max_abs(self, bound: Self) -> Self {
        self.zip(bound, |a, b| if a.abs() > b || a.is_nan() { a.abs() } else { b })
    }
    #[inline(always)]
    fn run<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
    #[inline(never)]
    fn apart<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
}

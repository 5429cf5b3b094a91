//! What the equations of a step are written in: one number for each stage, of sixteen digits or of thirty-two.
//!
//! [`Lanes`] are doubles; [`Double`] are pairs of them. The poses, residuals and sweeps are written once, over [`Numbers`], so that a
//! step can be solved to sixteen digits fast and then to thirty-two ([`super::precise`]) by the same lines. What does not mix stages asks for
//! [`Arithmetic`] alone, and can be worked out for [one](Numbers::One) of them ([`super::ending`]).

use super::lanes::Lanes;
use super::turns::{half_angle, half_angle_of_few};
use std::ops::{Add, Mul, Neg, Sub};

mod double;
mod fused;
mod mixing;

pub use double::Double;
pub use fused::Fused;
pub(super) use mixing::{InLines, Mixing, ReadBack, Shuffled, mix_from_memory, mix_stored_before};
use mixing::{one_by_one, stored};

/// The arithmetic of a step: of one number for each stage, or of one alone.
pub trait Arithmetic:
    Copy + Send + 'static + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// What is known of the start of a step, with as many digits.
    type Real: Copy + Default + Send + 'static;
    /// The same double for all stages.
    fn splat(value: f64) -> Self;
    /// The same number for all stages.
    fn whole(value: Self::Real) -> Self;
    /// The number of one lane; of one alone whatever lane it is.
    fn lane(self, lane: usize) -> Self::Real;
    /// `self · b + c`.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `c − self · b`.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// What rounding has cut off `product`, which is `self · b` rounded; nothing of numbers that keep it.
    fn lost(self, b: Self, product: Self) -> Self;
    /// `1 / self`.
    fn reciprocal(self) -> Self;

    /// All zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
}

/// One number for each stage.
pub trait Numbers: Arithmetic {
    /// One stage alone; or several, where they are to be had no cheaper.
    type One: Arithmetic<Real = Self::Real>;
    /// What is known of the start of a step, from a double.
    fn real(value: f64) -> Self::Real;
    /// Doubles for the stages, zero above their end, and what rounding has cut off them, for those who keep it.
    fn from_parts(high: &[f64], low: &[f64]) -> Self;
    /// Mixes stages: `Σ_i columns[i] · self[i]`, a matrix (by columns) times the vector of the stages.
    fn mix(self, columns: &[Self]) -> Self;
    /// [`Numbers::mix`] of several.
    #[inline(always)]
    fn mix_all<const N: usize>(values: [Self; N], columns: &[Self]) -> [Self; N] {
        one_by_one(values, columns)
    }
    /// Whether what is mixed is better stored long before.
    const STORES_EARLY: bool;
    /// The stages one after the other, in memory.
    type Stored: Copy + Send;
    /// Several in memory.
    fn store_all<const N: usize>(values: [Self; N]) -> InLines<Self::Stored, N>;
    /// [`Numbers::mix`] of several that are in memory, to the same bits.
    fn mix_stored<const N: usize>(values: &InLines<Self::Stored, N>, columns: &[Self]) -> [Self; N];
    /// Sums over the stages of several, `Σ_i weights[i] · value of stage i`, to the bits of [`Numbers::mix`] with these for all stages.
    fn weigh_all<const N: usize>(values: [Self; N], weights: &[Self::One]) -> [Self::One; N];
    /// One lane alone.
    #[inline(always)]
    fn alone(self, lane: usize) -> Self::One {
        Self::One::whole(self.lane(lane))
    }
    /// The larger of `|self|` and `bound`, which is not negative, stage by stage, to sixteen digits; a NaN in either gives NaN.
    fn max_abs(self, bound: Self) -> Self;
    /// Largest of numbers that are not negative, to sixteen digits; NaN if any is NaN.
    fn largest(self) -> f64;
    /// `cos(φ/2)` and `sin(φ/2)/φ` from `φ²`, for `φ ≤` [`MAX_TURN`](super::stage::MAX_TURN), or `φ ≤` [`FEW`](super::turns::FEW) where
    /// few terms are asked for.
    fn half_angle(square: Self, few: bool) -> (Self, Self);
}

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

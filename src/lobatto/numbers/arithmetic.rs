//! The number type of the equations of a step: one number for each stage, of sixteen digits or of thirty-two.
//!
//! `Lanes` are doubles; `Double` are pairs of them. The poses, residuals and sweeps are written once, over [`Numbers`], so that a step can be solved
//! to sixteen digits fast and then to thirty-two ([`crate::step::precise`]) by the same lines. Code that does not mix stages requires [`Arithmetic`]
//! alone, and can run for [one](Numbers::One) of them ([`crate::ending::velocities`]).

use std::ops::{Add, Mul, Neg, Sub};

/// The arithmetic of a step: of one number for each stage, or of one alone.
pub trait Arithmetic:
    Copy + Send + Sync + 'static + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// Number type of the start of a step, with as many digits.
    type Real: Copy + Default + Send + Sync + 'static;
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
    /// The rounding error of `product`, which is `self · b` rounded; zero for numbers that do not keep it.
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
    /// A number of the start of a step, from a double.
    fn real(value: f64) -> Self::Real;
    /// Doubles for the stages, zero above their end, and their rounding errors, for numbers that keep them.
    fn from_parts(high: &[f64], low: &[f64]) -> Self;
    /// Mixes stages: `Σ_i columns[i] · self[i]`, a matrix (by columns) times the vector of the stages.
    fn mix(self, columns: &[Self]) -> Self;
    /// [`Numbers::mix`] of several.
    #[inline(always)]
    fn mix_all<const N: usize>(values: [Self; N], columns: &[Self]) -> [Self; N] {
        one_by_one(values, columns)
    }
    /// Whether the operands of sums over stages are better stored long before.
    const STORES_EARLY: bool;
    /// The stages one after the other, in memory.
    type Stored: Copy + Send + Sync;
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
    /// `cos(φ/2)` and `sin(φ/2)/φ` from `φ²`, for `φ ≤` [`MAX_TURN`](crate::stages::pose::MAX_TURN), or `φ ≤` [`FEW`](crate::numbers::series::FEW)
    /// where few terms are asked for.
    fn half_angle(square: Self, few: bool) -> (Self, Self);
}

/// Arrays that begin at the border of a cache line: a value stored across a border is read back late.
#[repr(align(64))]
#[derive(Clone, Copy)]
pub struct InLines<A, const N: usize>(pub [A; N]);

/// [`Numbers::mix`] of one after the other.
#[inline(always)]
pub(crate) fn one_by_one<V: Numbers, const N: usize>(mut values: [V; N], columns: &[V]) -> [V; N] {
    let mut index = 0;
    while index < N {
        values[index] = values[index].mix(columns);
        index += 1;
    }
    values
}

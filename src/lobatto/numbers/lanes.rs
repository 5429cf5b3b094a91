//! Stages as SIMD lanes: the vectors in which all stages of a step are computed at once.
//!
//! Lane `j` holds stage `j + 2` of an s-stage step (the first stage is the known start), so that a step of s stages
//! fills s − 1 lanes; the lanes above that carry zeros. The kernel is written once, over the [`Lanes`] trait, and
//! instantiated for the widest vectors the processor has, found at run time ([`Isa::detect`]). The vectors of x86-64 are in a
//! file of their own, the only one with `unsafe`.

use crate::numbers::arithmetic::InLines;
use std::ops::{Add, Mul, Neg, Sub};

/// The largest number of lanes any vector type has.
pub const MAX_LANES: usize = 16;

/// How vectors are mixed.
pub trait Mixing<V: Lanes> {
    /// Value of `Numbers::STORES_EARLY` for these lanes.
    const EARLY: bool;
    /// Their type in memory.
    type Stored: Copy + Send + Sync;
    /// `Numbers::mix_all`.
    fn mix_all<const N: usize>(values: [V; N], columns: &[V]) -> [V; N];
    /// `Numbers::store_all`.
    fn store_all<const N: usize>(values: [V; N]) -> InLines<Self::Stored, N>;
    /// `Numbers::mix_stored`.
    fn mix_stored<const N: usize>(values: &InLines<Self::Stored, N>, columns: &[V]) -> [V; N];
}

/// A vector of `COUNT` doubles, one for each lane, with the arithmetic the kernel needs.
pub trait Lanes:
    Copy + Send + Sync + 'static + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// Number of lanes.
    const COUNT: usize;
    /// Whether these vectors carry the most general sweeps alone, with forces and with twice the digits of the coefficients: few runs
    /// use them, and every sweep takes its share of the build. A condition that begins with it is known before anything in it is compiled.
    const GENERAL_ALONE: bool = false;
    /// How they are mixed.
    type Mixing: crate::numbers::lanes::Mixing<Self>;
    /// `[f64; COUNT]`.
    type Array: Copy + Send + Sync + AsRef<[f64]> + AsMut<[f64]>;
    /// The same lanes in single precision, if that is cheaper.
    type Single: crate::numbers::arithmetic::Numbers;
    /// Whether they are.
    const HAS_SINGLE: bool;
    /// One lane alone.
    type One: crate::numbers::arithmetic::Arithmetic<Real = f64>;
    /// Two of them, with the arithmetic of one alone, to the bit.
    type Two: Lanes<Array = [f64; 2]>;
    /// To single precision.
    fn narrow(self) -> Self::Single;
    /// Converts single precision.
    fn widen(single: Self::Single) -> Self;
    /// All lanes equal.
    fn splat(value: f64) -> Self;
    /// The lanes of an array.
    fn from_array(array: Self::Array) -> Self;
    /// The lanes as an array.
    fn to_array(self) -> Self::Array;
    /// An array of zeros.
    fn zero_array() -> Self::Array;
    /// `self · b + c`.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `c − self · b`.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// The rounding error of `product`, which is `self · b` rounded: exact.
    #[inline(always)]
    fn lost(self, b: Self, product: Self) -> Self {
        self.mul_add(b, -product)
    }
    /// `1 / self`.
    fn reciprocal(self) -> Self;
    /// The larger of `|self|` and `bound`, which is not negative, lane by lane; a NaN in either gives NaN.
    fn max_abs(self, bound: Self) -> Self;
    /// Runs `work` compiled for this vector type.
    fn run<R>(work: impl FnOnce() -> R) -> R;
    /// The same in a function of its own, which is compiled once however often it is called.
    fn apart<R>(work: impl FnOnce() -> R) -> R;

    /// All lanes zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// The lanes of a slice, zero above its end.
    fn from_slice(values: &[f64]) -> Self {
        let mut array = Self::zero_array();
        array.as_mut()[..values.len()].copy_from_slice(values);
        Self::from_array(array)
    }

    /// The square root of every lane. Few are needed, so that the compiler's vectors of an array are enough.
    #[inline(always)]
    fn square_root(self) -> Self {
        let mut array = self.to_array();
        for lane in array.as_mut() {
            *lane = lane.sqrt();
        }
        Self::from_array(array)
    }

    /// Mixes lanes: `Σ_i columns[i] · self[i]`, a matrix (by columns) times the vector of the lanes.
    #[inline(always)]
    fn mix(self, columns: &[Self]) -> Self {
        let array = self.to_array();
        let lanes = array.as_ref();
        let mut sum = columns[0] * Self::splat(lanes[0]);
        let mut index = 1;
        while index < Self::COUNT {
            sum = columns[index].mul_add(Self::splat(lanes[index]), sum);
            index += 1;
        }
        sum
    }

    /// Sum of all lanes, the upper half folded onto the lower again and again: zeros above the lanes in use do not
    /// change a bit of it, so that it is the same for every vector type.
    #[inline(always)]
    fn sum(self) -> f64 {
        let mut array = self.to_array();
        let lanes = array.as_mut();
        let mut half = Self::COUNT / 2;
        while half > 0 {
            let mut lane = 0;
            while lane < half {
                lanes[lane] += lanes[lane + half];
                lane += 1;
            }
            half /= 2;
        }
        lanes[0]
    }

    /// Largest of lanes that are not negative; NaN if any lane is NaN.
    #[inline(always)]
    fn largest(self) -> f64 {
        let array = self.to_array();
        // Doubles without sign are ordered as their bits are, and a NaN comes last: no comparison of doubles, no branch.
        let mut bits = 0;
        for lane in array.as_ref() {
            bits = lane.to_bits().max(bits);
        }
        f64::from_bits(bits)
    }
}

/// Runs an expression compiled for the vector type: everything in it is inlined there.
macro_rules! in_lanes {
    ($vector:ty, $work:expr) => {
        <$vector>::run(
            #[inline(always)]
            || $work,
        )
    };
}
pub(crate) use in_lanes;

/// The vector instructions of a processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// No more than the build promises.
    Portable,
    /// AVX2 with fused multiply-add: four lanes an instruction.
    Avx2,
    /// AVX-512F: eight lanes an instruction.
    Avx512,
}

impl Isa {
    /// The widest vectors of the processor this runs on.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl") {
                Isa::Avx512
            } else {
                Isa::Avx2
            };
        }
        Isa::Portable
    }

    /// Name for reports.
    pub fn name(self) -> &'static str {
        match self {
            Isa::Portable => "portable",
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
        }
    }
}

//! Stages as SIMD lanes: the vectors in which all stages of a step are computed at once.
//!
//! Lane `j` holds stage `j + 2` of an s-stage step (the first stage is the known start), so that a step of s stages
//! fills s − 1 lanes; the lanes above that carry zeros. The kernel is written once, over the [`Lanes`] trait, and
//! instantiated for the widest vectors the processor has, found at run time ([`Isa::detect`]). The vectors of x86-64 are in a
//! file of their own, the only one with `unsafe`.

use std::ops::{Add, Mul, Neg, Sub};

/// A vector of `COUNT` doubles, one for each lane, with the arithmetic the kernel needs.
pub trait Lanes:
    Copy + Send + 'static + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// Number of lanes.
    const COUNT: usize;
    /// Whether these vectors carry the most general sweeps alone, with forces and with twice the digits of the coefficients: few runs
    /// use them, and every sweep takes its share of the build. A condition that begins with it is known before anything in it is compiled.
    const GENERAL_ALONE: bool = false;
    /// How they are mixed.
    type Mixing: super::numbers::Mixing<Self>;
    /// `[f64; COUNT]`.
    type Array: Copy + Send + AsRef<[f64]> + AsMut<[f64]>;
    /// The same lanes in single precision, where those are cheaper.
    type Single: super::numbers::Numbers;
    /// Whether they are.
    const HAS_SINGLE: bool;
    /// One lane alone.
    type One: super::numbers::Arithmetic<Real = f64>;
    /// To single precision.
    fn narrow(self) -> Self::Single;
    /// From single precision.
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
    /// What rounding has cut off `product`, which is `self · b` rounded: exact.
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
pub(super) use in_lanes;

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

macro_rules! operators {
    ($name:ty, $($generics:tt)*) => {
        impl<$($generics)*> Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self { Self::lane_add(self, other) }
        }
        impl<$($generics)*> Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self { Self::lane_sub(self, other) }
        }
        impl<$($generics)*> Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self { Self::lane_mul(self, other) }
        }
        impl<$($generics)*> Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self { Self::lane_sub(Self::splat(0.0), self) }
        }
    };
}

/// The items of [`Lanes`] for vectors to which single precision brings nothing.
macro_rules! double_alone {
    () => {
        type Single = Self;
        const HAS_SINGLE: bool = false;
        #[inline(always)]
        fn narrow(self) -> Self {
            self
        }
        #[inline(always)]
        fn widen(single: Self) -> Self {
            single
        }
    };
}

mod portable;

pub use portable::Portable;

#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx128, Avx256, Avx512, Single, Sse2};

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86;

#[cfg(target_arch = "x86_64")]
mod single;

#[cfg(target_arch = "x86_64")]
mod pair;

#[cfg(target_arch = "x86_64")]
pub(crate) use pair::Pair;

/// Calls a function for every vector type of this processor.
#[cfg(test)]
macro_rules! in_every_vector {
    ($check:ident) => {
        use $crate::lobatto::lanes::*;
        $check::<Portable<4>>();
        $check::<Portable<8>>();
        $check::<Portable<16>>();
        #[cfg(target_arch = "x86_64")]
        {
            $check::<Sse2>();
            $check::<Pair<Sse2, 4>>();
            if Isa::detect() != Isa::Portable {
                $check::<Avx128>();
                $check::<Avx256>();
                $check::<Pair<Avx256, 8>>();
                $check::<Pair<Pair<Avx256, 8>, 16>>();
            }
            if Isa::detect() == Isa::Avx512 {
                $check::<Avx512>();
                $check::<Pair<Avx512, 16>>();
            }
        }
    };
}

#[cfg(test)]
pub(super) use in_every_vector;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobatto::numbers::{InLines, Numbers, mix_from_memory};
    use crate::lobatto::turns::{FEW, half_angle, half_angle_of_few};

    fn keeps_nan<N: Numbers>() {
        let [nan, two, minus_three] = [f64::NAN, 2.0, -3.0].map(N::splat);
        assert_eq!([minus_three.max_abs(two), two.max_abs(-minus_three)].map(N::largest), [3.0, 3.0]);
        // The NaN of 0/0 has a sign on some processors.
        for nan in [nan, -nan] {
            assert!(nan.max_abs(two).largest().is_nan(), "the value");
            assert!(two.max_abs(nan.max_abs(two)).largest().is_nan(), "one before it");
        }
    }

    fn vector<V: Lanes>(seed: usize) -> V {
        V::from_slice(&(0..V::COUNT).map(|lane| ((seed * 31 + lane * 17) as f64).sin()).collect::<Vec<f64>>())
    }

    #[test]
    fn no_nan_is_lost() {
        fn in_lanes<V: Lanes>() {
            V::run(keeps_nan::<V>);
        }
        in_every_vector!(in_lanes);
        #[cfg(target_arch = "x86_64")]
        if Isa::detect() != Isa::Portable {
            Avx256::run(keeps_nan::<Single>);
        }
    }

    #[test]
    fn what_rounding_cuts_off_a_product_is_known_exactly() {
        fn holds<V: Lanes>() {
            let (own, other): (V, V) = (vector(7), vector(8));
            let (product, lost) = V::run(|| {
                let product = own * other;
                (product.to_array(), own.lost(other, product).to_array())
            });
            for lane in 0..V::COUNT {
                let [own, other] = [own, other].map(|value| value.to_array().as_ref()[lane]);
                assert_eq!(product.as_ref()[lane], own * other, "lane {lane}");
                assert_eq!(lost.as_ref()[lane], own.mul_add(other, -(own * other)), "lane {lane}");
            }
            assert!(lost.as_ref().iter().any(|&lost| lost != 0.0), "some of it is lost");
        }
        in_every_vector!(holds);
    }

    fn mixes_and_turns<V: Lanes>() {
        V::run(|| {
            let columns: Vec<V> = (0..V::COUNT).map(|column| vector(100 + column)).collect();
            let arrays = InLines([vector::<V>(1), vector(2), vector(3)].map(V::to_array));
            let together = mix_from_memory(&arrays, &columns);
            for (index, together) in together.into_iter().enumerate() {
                let apart = vector::<V>(index + 1).mix(&columns);
                assert_eq!(together.to_array().as_ref(), apart.to_array().as_ref(), "vector {index}");
            }
            for part in 0..=100 {
                let square = V::splat((FEW * f64::from(part) / 100.0).powi(2));
                let (few, all) = (half_angle_of_few(square), half_angle(square));
                for (few, all) in [(few.0, all.0), (few.1, all.1)] {
                    // One rounding of numbers of size one; the first term left out is 2e-17.
                    let off = (few - all).max_abs(V::zero()).largest();
                    assert!(off <= f64::EPSILON, "{part} % of {FEW} rad: {off:e}");
                }
            }
        });
    }

    #[test]
    fn vectors_mixed_from_memory_have_the_bits_of_each_mixed_alone_and_small_turns_need_few_terms() {
        in_every_vector!(mixes_and_turns);
    }
}

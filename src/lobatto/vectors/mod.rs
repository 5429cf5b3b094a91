//! The vectors of the processors: lanes in registers of x86-64, and arrays of doubles everywhere else.

use crate::numbers::lanes::{Isa, Lanes};

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

/// The items of [`Lanes`] for vectors that have no faster form in single precision.
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

pub mod portable;

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
pub(crate) mod x86;

#[cfg(target_arch = "x86_64")]
mod single;

#[cfg(target_arch = "x86_64")]
pub(crate) mod pair;

/// Work that is generic over the vector type.
pub trait InVectors {
    /// The result of the work.
    type Output;
    /// Runs the work with the lanes of `V`.
    fn with<V: Lanes>(self) -> Self::Output;
}

/// Runs work in the narrowest AVX-512 vectors with at least this many `lanes`; `None` without AVX-512, or where narrower vectors suffice.
#[cfg(target_arch = "x86_64")]
pub fn in_avx512<W: InVectors>(lanes: usize, work: W) -> Option<W::Output> {
    if Isa::detect() != Isa::Avx512 {
        return None;
    }
    match lanes {
        ..=4 => None,
        5..=8 => Some(work.with::<x86::Avx512>()),
        _ => Some(work.with::<pair::Pair<x86::Avx512, 16>>()),
    }
}

/// Runs work in eight lanes of AVX-512; `None` on processors without it.
#[cfg(target_arch = "x86_64")]
pub fn eight_in_avx512<W: InVectors>(work: W) -> Option<W::Output> {
    (Isa::detect() == Isa::Avx512).then(|| work.with::<x86::Avx512>())
}

/// Runs work in the narrowest AVX2 vectors with at least this many `lanes`; `None` without AVX2.
#[cfg(target_arch = "x86_64")]
pub fn in_avx2<W: InVectors>(lanes: usize, work: W) -> Option<W::Output> {
    use pair::Pair;
    if Isa::detect() == Isa::Portable {
        return None;
    }
    Some(match lanes {
        ..=2 => work.with::<x86::Avx128>(),
        3..=4 => work.with::<x86::Avx256>(),
        5..=8 => work.with::<Pair<x86::Avx256, 8>>(),
        _ => work.with::<Pair<Pair<x86::Avx256, 8>, 16>>(),
    })
}

/// Runs work in the narrowest AVX2 vectors with at least this many `lanes`, up to four; `None` without AVX2, and for more lanes.
#[cfg(target_arch = "x86_64")]
pub fn in_avx2_up_to_four<W: InVectors>(lanes: usize, work: W) -> Option<W::Output> {
    if Isa::detect() == Isa::Portable {
        return None;
    }
    match lanes {
        ..=2 => Some(work.with::<x86::Avx128>()),
        3..=4 => Some(work.with::<x86::Avx256>()),
        _ => None,
    }
}

/// Runs work in eight lanes of AVX2; `None` on processors without it.
#[cfg(target_arch = "x86_64")]
pub fn eight_in_avx2<W: InVectors>(work: W) -> Option<W::Output> {
    (Isa::detect() != Isa::Portable).then(|| work.with::<pair::Pair<x86::Avx256, 8>>())
}

/// Runs no work: the vectors are not compiled.
pub fn no_vectors<W: InVectors>(_work: W) -> Option<W::Output> {
    None
}

/// The same, for any number of lanes.
pub fn no_vectors_of<W: InVectors>(_lanes: usize, _work: W) -> Option<W::Output> {
    None
}

/// Runs work in the narrowest vectors of every processor with at least this many `lanes`. On x86-64 there are only two types: few processors lack
/// AVX2, and each type adds to the build time.
pub fn in_portable<W: InVectors>(lanes: usize, work: W) -> W::Output {
    match lanes {
        #[cfg(target_arch = "x86_64")]
        ..=4 => work.with::<pair::Pair<x86::Sse2, 4>>(),
        #[cfg(not(target_arch = "x86_64"))]
        ..=2 => work.with::<portable::Portable<2>>(),
        #[cfg(not(target_arch = "x86_64"))]
        3..=4 => work.with::<portable::Portable<4>>(),
        #[cfg(not(target_arch = "x86_64"))]
        5..=8 => work.with::<portable::Portable<8>>(),
        _ => work.with::<portable::Portable<16>>(),
    }
}

/// Runs work in eight lanes on any processor.
pub fn eight_in_portable<W: InVectors>(work: W) -> W::Output {
    work.with::<portable::Portable<8>>()
}

/// Runs work with at least eight lanes on any processor. On x86-64 this uses a type that steps of many stages need anyway, so that it adds no build
/// time.
pub fn wide_in_portable<W: InVectors>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    type Wide = portable::Portable<16>;
    #[cfg(not(target_arch = "x86_64"))]
    type Wide = portable::Portable<8>;
    work.with::<Wide>()
}

/// Calls a function for every vector type of this processor.
#[cfg(test)]
macro_rules! in_every_vector {
    ($check:ident) => {
        use $crate::numbers::lanes::*;
        use $crate::vectors::pair::*;
        use $crate::vectors::portable::*;
        use $crate::vectors::x86::*;
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
pub(crate) use in_every_vector;

#[cfg(test)]
mod tests {

    use crate::numbers::arithmetic::{InLines, Numbers};
    use crate::numbers::lanes::Lanes;
    use crate::numbers::mixing::mix_from_memory;
    use crate::numbers::series::{FEW, half_angle, half_angle_of_few};

    fn keeps_nan<N: Numbers>() {
        let [nan, two, minus_three] = [f64::NAN, 2.0, -3.0].map(N::splat);
        assert_eq!([minus_three.max_abs(two), two.max_abs(-minus_three)].map(N::largest), [3.0, 3.0]);
        // On some processors the NaN of 0/0 has a sign.
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
                    // The bound is one rounding of numbers of size one; the first neglected term is 2e-17.
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

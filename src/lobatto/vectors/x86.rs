//! The vectors of x86-64: the only file with `unsafe`.
//!
//! Two proofs carry every block in it:
//!
//! - **P1** — the intrinsics of a vector type need a processor feature. Every x86-64 processor has the features of [`Sse2`]. The other types cannot
//!   be named outside this crate. In it only the gates of [`crate::vectors`] begin with one, after
//!   [`Isa::detect`](crate::numbers::lanes::Isa::detect) has found `avx2` and `fma` (and `avx512f` and `avx512vl` for [`Avx512`]), and tests that ask
//!   the same; `pair` and `single` make others from given ones. Who is handed a type by a gate runs behind its question.
//! - **P2** — loads and stores go through arrays of exactly the vector's length, by value or reference, so that
//!   they cannot leave the array; the unaligned forms are used, so that alignment is no condition.

use crate::numbers::fused::Fused;
use crate::numbers::lanes::Lanes;
use crate::numbers::mixing::{ReadBack, Shuffled};
use crate::vectors::portable::Portable;
use std::arch::x86_64::*;
use std::ops::{Add, Mul, Neg, Sub};

/// Makes the frame of the function that this is inlined into begin at the border of a cache line. The compiler decides on that before it knows that
/// registers will be kept on the stack. Without this, the preceding calls decide whether all 512-bit slots and half of the 256-bit slots reach over
/// such a border.
#[inline(always)]
fn align_frame() {
    #[repr(align(64))]
    struct Line(#[expect(dead_code, reason = "its place counts")] u8);
    // Mutable, or it would be a constant somewhere else.
    std::hint::black_box(&mut Line(0));
}

macro_rules! vector {
    ($(#[$doc:meta])* $name:ident, $raw:ty, $count:literal, $mixing:ident, $features:literal,
     $set1:ident, $load:ident, $store:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $fmadd:expr, $fnmadd:expr,
     $max_abs:expr, { $($precision:tt)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $name($raw);

        impl $name {
            #[inline(always)]
            fn lane_add(self, other: Self) -> Self {
                // SAFETY: P1.
                $name(unsafe { $add(self.0, other.0) })
            }
            #[inline(always)]
            fn lane_sub(self, other: Self) -> Self {
                // SAFETY: P1.
                $name(unsafe { $sub(self.0, other.0) })
            }
            #[inline(always)]
            fn lane_mul(self, other: Self) -> Self {
                // SAFETY: P1.
                $name(unsafe { $mul(self.0, other.0) })
            }
        }

        operators!($name,);

        impl Lanes for $name {
            const COUNT: usize = $count;
            type Mixing = $mixing;
            type Array = [f64; $count];
            $($precision)*
            #[inline(always)]
            fn splat(value: f64) -> Self {
                // SAFETY: P1.
                $name(unsafe { $set1(value) })
            }
            #[inline(always)]
            fn from_array(array: [f64; $count]) -> Self {
                // SAFETY: P1 and P2.
                $name(unsafe { $load(array.as_ptr()) })
            }
            #[inline(always)]
            fn to_array(self) -> [f64; $count] {
                let mut array = [0.0; $count];
                // SAFETY: P1 and P2.
                unsafe { $store(array.as_mut_ptr(), self.0) };
                array
            }
            #[inline(always)]
            fn zero_array() -> [f64; $count] {
                [0.0; $count]
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                // SAFETY: P1.
                $name(unsafe { $fmadd(self.0, b.0, c.0) })
            }
            #[inline(always)]
            fn neg_mul_add(self, b: Self, c: Self) -> Self {
                // SAFETY: P1.
                $name(unsafe { $fnmadd(self.0, b.0, c.0) })
            }
            #[inline(always)]
            fn reciprocal(self) -> Self {
                // SAFETY: P1.
                $name(unsafe { $div($set1(1.0), self.0) })
            }
            #[inline(always)]
            fn max_abs(self, bound: Self) -> Self {
                // As integers: doubles without sign are ordered as their bits are, and a NaN comes last.
                // SAFETY: P1.
                $name(unsafe { $max_abs(self.0, bound.0) })
            }
            #[inline(always)]
            fn run<R>(work: impl FnOnce() -> R) -> R {
                #[target_feature(enable = $features)]
                fn with_features<R>(work: impl FnOnce() -> R) -> R {
                    align_frame();
                    work()
                }
                // SAFETY: P1.
                unsafe { with_features(work) }
            }
            #[inline(always)]
            fn apart<R>(work: impl FnOnce() -> R) -> R {
                #[target_feature(enable = $features)]
                #[inline(never)]
                fn with_features<R>(work: impl FnOnce() -> R) -> R {
                    work()
                }
                // SAFETY: P1.
                unsafe { with_features(work) }
            }
        }
    };
}

vector!(
    /// Two lanes in a 128-bit register without AVX2, where a product is rounded before it is added to.
    Sse2, __m128d, 2, Shuffled, "sse2",
    _mm_set1_pd, _mm_loadu_pd, _mm_storeu_pd, _mm_add_pd, _mm_sub_pd, _mm_mul_pd, _mm_div_pd,
    |a, b, c| _mm_add_pd(_mm_mul_pd(a, b), c), |a, b, c| _mm_sub_pd(c, _mm_mul_pd(a, b)),
    |a, b| {
        let size = _mm_andnot_pd(_mm_set1_pd(-0.0), a);
        let larger = _mm_or_pd(_mm_cmpunord_pd(size, size), _mm_cmplt_pd(b, size));
        _mm_or_pd(_mm_and_pd(larger, size), _mm_andnot_pd(larger, b))
    },
    {
        double_alone!();
        type One = Portable<1>;
        type Two = Sse2;
        #[inline(always)]
        fn lost(self, b: Self, product: Self) -> Self {
            // Slow where the processor cannot, but right.
            let (own, b, product) = (self.to_array(), b.to_array(), product.to_array());
            Self::from_array([0, 1].map(|lane| own[lane].mul_add(b[lane], -product[lane])))
        }
    }
);
vector!(
    /// Two lanes in a 128-bit register.
    Avx128, __m128d, 2, Shuffled, "avx2,fma",
    _mm_set1_pd, _mm_loadu_pd, _mm_storeu_pd, _mm_add_pd, _mm_sub_pd, _mm_mul_pd, _mm_div_pd, _mm_fmadd_pd, _mm_fnmadd_pd,
    |a, b| {
        let size = _mm_andnot_pd(_mm_set1_pd(-0.0), a);
        let larger = _mm_cmpgt_epi64(_mm_castpd_si128(size), _mm_castpd_si128(b));
        _mm_blendv_pd(b, size, _mm_castsi128_pd(larger))
    },
    {
        double_alone!();
        type One = Fused;
        type Two = Avx128;
    }
);
vector!(
    /// Four lanes in a 256-bit register.
    Avx256, __m256d, 4, Shuffled, "avx2,fma",
    _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd,
    _mm256_fmadd_pd, _mm256_fnmadd_pd,
    |a, b| {
        let size = _mm256_andnot_pd(_mm256_set1_pd(-0.0), a);
        let larger = _mm256_cmpgt_epi64(_mm256_castpd_si256(size), _mm256_castpd_si256(b));
        _mm256_blendv_pd(b, size, _mm256_castsi256_pd(larger))
    },
    {
        double_alone!();
        type One = Fused;
        type Two = Avx128;
        #[inline(always)]
        fn sum(self) -> f64 {
            // Written out, because of the fold over an array the compiler makes twice as many shuffles.
            // SAFETY: P1.
            unsafe {
                let two = _mm_add_pd(_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0));
                _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)))
            }
        }
    }
);
vector!(
    /// Eight lanes in a 512-bit register.
    Avx512, __m512d, 8, ReadBack, "avx512f,avx512vl,avx2,fma",
    _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd,
    _mm512_fmadd_pd, _mm512_fnmadd_pd,
    |a, b| _mm512_castsi512_pd(_mm512_max_epi64(_mm512_castpd_si512(_mm512_abs_pd(a)), _mm512_castpd_si512(b))),
    {
        type Single = Single;
        type One = Fused;
        type Two = Avx128;
        const HAS_SINGLE: bool = true;
        #[inline(always)]
        fn sum(self) -> f64 {
            // SAFETY: P1.
            Avx256(unsafe { _mm256_add_pd(_mm512_castpd512_pd256(self.0), _mm512_extractf64x4_pd::<1>(self.0)) }).sum()
        }
        #[inline(always)]
        fn narrow(self) -> Single {
            // SAFETY: P1.
            Single(unsafe { _mm512_cvtpd_ps(self.0) })
        }
        #[inline(always)]
        fn widen(single: Single) -> Self {
            // SAFETY: P1.
            Avx512(unsafe { _mm512_cvtps_pd(single.0) })
        }
    }
);

/// Eight lanes of single precision in a 256-bit register; their arithmetic is in [`crate::vectors::single`].
#[derive(Clone, Copy)]
pub struct Single(__m256);

impl Single {
    /// All lanes equal.
    #[inline(always)]
    pub(crate) fn all(value: f32) -> Self {
        // SAFETY: P1.
        Single(unsafe { _mm256_set1_ps(value) })
    }
    /// The lanes of an array.
    #[inline(always)]
    pub(crate) fn from_array(array: [f32; 8]) -> Self {
        // SAFETY: P1 and P2.
        Single(unsafe { _mm256_loadu_ps(array.as_ptr()) })
    }
    /// The lanes as an array.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f32; 8] {
        let mut array = [0.0; 8];
        // SAFETY: P1 and P2.
        unsafe { _mm256_storeu_ps(array.as_mut_ptr(), self.0) };
        array
    }
    #[inline(always)]
    pub(crate) fn lane_add(self, other: Self) -> Self {
        // SAFETY: P1.
        Single(unsafe { _mm256_add_ps(self.0, other.0) })
    }
    #[inline(always)]
    pub(crate) fn lane_sub(self, other: Self) -> Self {
        // SAFETY: P1.
        Single(unsafe { _mm256_sub_ps(self.0, other.0) })
    }
    #[inline(always)]
    pub(crate) fn lane_mul(self, other: Self) -> Self {
        // SAFETY: P1.
        Single(unsafe { _mm256_mul_ps(self.0, other.0) })
    }
    #[inline(always)]
    pub(crate) fn over(self, other: Self) -> Self {
        // SAFETY: P1.
        Single(unsafe { _mm256_div_ps(self.0, other.0) })
    }
    #[inline(always)]
    pub(crate) fn fused(self, b: Self, c: Self) -> Self {
        // SAFETY: P1.
        Single(unsafe { _mm256_fmadd_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    pub(crate) fn fused_from(self, b: Self, c: Self) -> Self {
        // SAFETY: P1.
        Single(unsafe { _mm256_fnmadd_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    pub(crate) fn max_size(self, bound: Self) -> Self {
        // SAFETY: P1.
        unsafe {
            let size = _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0);
            let larger = _mm256_max_epi32(_mm256_castps_si256(size), _mm256_castps_si256(bound.0));
            Single(_mm256_castsi256_ps(larger))
        }
    }
    /// In double precision, lower and upper half.
    #[inline(always)]
    pub(crate) fn halves(self) -> [Avx256; 2] {
        // SAFETY: P1.
        unsafe {
            [
                Avx256(_mm256_cvtps_pd(_mm256_castps256_ps128(self.0))),
                Avx256(_mm256_cvtps_pd(_mm256_extractf128_ps::<1>(self.0))),
            ]
        }
    }
    /// Converts double precision, lower and upper half.
    #[inline(always)]
    pub(crate) fn from_halves(low: Avx256, high: Avx256) -> Self {
        // SAFETY: P1.
        Single(unsafe { _mm256_set_m128(_mm256_cvtpd_ps(high.0), _mm256_cvtpd_ps(low.0)) })
    }
}

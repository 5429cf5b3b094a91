//! One lane alone, with the arithmetic of the vectors that it comes from, to the bit.

use super::Arithmetic;
use std::ops::{Add, Mul, Neg, Sub};

/// A number of sixteen digits for one stage; `FUSED` where a product is not rounded before it is added to.
#[derive(Clone, Copy)]
pub struct One<const FUSED: bool>(f64);

impl<const FUSED: bool> Add for One<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        One(self.0 + other.0)
    }
}

impl<const FUSED: bool> Sub for One<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        One(self.0 - other.0)
    }
}

impl<const FUSED: bool> Mul for One<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        One(self.0 * other.0)
    }
}

impl<const FUSED: bool> Neg for One<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // As lanes do it.
        One(0.0 - self.0)
    }
}

impl<const FUSED: bool> Arithmetic for One<FUSED> {
    type Real = f64;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        One(value)
    }
    #[inline(always)]
    fn whole(value: f64) -> Self {
        One(value)
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self.0
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        One(if FUSED { self.0.mul_add(b.0, c.0) } else { self.0 * b.0 + c.0 })
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        One(if FUSED { (-self.0).mul_add(b.0, c.0) } else { c.0 - self.0 * b.0 })
    }
    #[inline(always)]
    fn lost(self, b: Self, product: Self) -> Self {
        // Exact, whatever the processor has.
        One(self.0.mul_add(b.0, -product.0))
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        One(1.0 / self.0)
    }
}

#[cfg(test)]
mod tests {
    use crate::lobatto::lanes::{Lanes, Portable};
    use crate::lobatto::numbers::{Arithmetic, Numbers};

    /// The seven operations of three numbers.
    fn results<N: Arithmetic>([x, y, z]: [N; 3], lane: usize) -> [N::Real; 7] {
        [x + y, x - y, -z, x.mul_add(y, z), x.neg_mul_add(y, z), y.reciprocal(), x.lost(y, x * y)]
            .map(|result| result.lane(lane))
    }

    fn one_lane_is_as_among_the_others<V: Lanes>() {
        let values = |seed: usize| (0..V::COUNT).map(move |lane| ((seed * 31 + lane * 17) as f64).sin());
        let vectors = [1, 2, 3].map(|seed| V::from_slice(&values(seed).collect::<Vec<f64>>()));
        V::run(|| {
            for lane in 0..V::COUNT {
                let alone = vectors.map(|vector| vector.alone(lane));
                assert_eq!(results(alone, 0), results(vectors, lane), "lane {lane}");
            }
            let columns: Vec<V> = values(4).map(<V as Arithmetic>::splat).collect();
            let weights: Vec<<V as Numbers>::One> = values(4).map(Arithmetic::splat).collect();
            let sums = Numbers::weigh_all(vectors, &weights).map(|sum| sum.lane(0));
            assert_eq!(sums, vectors.map(|vector| Numbers::mix(vector, &columns).lane(0)));
        });
    }

    #[test]
    fn one_lane_alone_has_the_bits_that_it_has_among_the_others_in_every_vector_the_processor_has() {
        one_lane_is_as_among_the_others::<Portable<4>>();
        one_lane_is_as_among_the_others::<Portable<16>>();
        #[cfg(target_arch = "x86_64")]
        {
            use crate::lobatto::lanes::{Avx128, Avx256, Avx512, Isa, Pair, Sse2};
            one_lane_is_as_among_the_others::<Pair<Sse2, 4>>();
            if Isa::detect() != Isa::Portable {
                one_lane_is_as_among_the_others::<Avx128>();
                one_lane_is_as_among_the_others::<Pair<Avx256, 8>>();
            }
            if Isa::detect() == Isa::Avx512 {
                one_lane_is_as_among_the_others::<Pair<Avx512, 16>>();
            }
        }
    }
}

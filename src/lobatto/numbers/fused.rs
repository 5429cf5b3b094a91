//! One lane alone of vectors that do not round a product before they add to it, with their arithmetic, to the bit; of others that is a vector
//! of one lane.

use crate::numbers::arithmetic::Arithmetic;
use std::ops::{Add, Mul, Neg, Sub};

/// A number of sixteen digits for one stage.
#[derive(Clone, Copy)]
pub struct Fused(f64);

impl Add for Fused {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Fused(self.0 + other.0)
    }
}

impl Sub for Fused {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Fused(self.0 - other.0)
    }
}

impl Mul for Fused {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Fused(self.0 * other.0)
    }
}

impl Neg for Fused {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // As lanes do it.
        Fused(0.0 - self.0)
    }
}

impl Arithmetic for Fused {
    type Real = f64;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Fused(value)
    }
    #[inline(always)]
    fn whole(value: f64) -> Self {
        Fused(value)
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self.0
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Fused(self.0.mul_add(b.0, c.0))
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Fused((-self.0).mul_add(b.0, c.0))
    }
    #[inline(always)]
    fn lost(self, b: Self, product: Self) -> Self {
        self.mul_add(b, -product)
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        Fused(1.0 / self.0)
    }
}

#[cfg(test)]
mod tests {
    use crate::numbers::arithmetic::{Arithmetic, Numbers};
    use crate::numbers::lanes::Lanes;
    use crate::vectors::in_every_vector;

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
        in_every_vector!(one_lane_is_as_among_the_others);
    }
}

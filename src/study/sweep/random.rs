//! Random numbers by their place: the draw of an entry in a run follows from the seed, the index of the run and the number of the entry alone.
//!
//! ```text
//!     mix(z):  z ← (z ⊕ z»30)·0xBF58476D1CE4E5B9,  z ← (z ⊕ z»27)·0x94D049BB133111EB,  z ⊕ z»31
//!     step(z): mix(z + 0x9E3779B97F4A7C15)
//!     bits(seed, index, entry, k) = step(step(step(step(seed) ⊕ index) ⊕ entry) ⊕ k)          k = 0, 1
//!     u = (bits » 11) · 2⁻⁵³ in [0, 1)
//!     uniform: a + (b − a) u        log-uniform: a exp(u ln(b/a))        normal: μ + σ √(−2 ln(1 − u₀)) cos(2π u₁)
//! ```
//!
//! Source: G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014 (`mix`); G. E. P. Box, M. E. Muller, A note
//! on the generation of random normal deviates, Ann. Math. Statist. 29 (1958). Logarithms and cosines come from the system: on another system the
//! last digit of log-uniform and normal numbers may differ.

use std::f64::consts::TAU;

/// How a number is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Law {
    /// Between two bounds.
    Uniform(f64, f64),
    /// Between two positive bounds, its logarithm uniform.
    LogUniform(f64, f64),
    /// Mean and standard deviation.
    Normal(f64, f64),
}

/// The place of a draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub seed: u64,
    pub index: u64,
    /// Which entry of the sweep file, from 0.
    pub entry: u64,
}

fn step(z: u64) -> u64 {
    let z = z.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

impl Place {
    /// A number in [0, 1), the `which`-th of this place.
    fn unit(self, which: u64) -> f64 {
        let bits = step(step(step(step(self.seed) ^ self.index) ^ self.entry) ^ which);
        (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

impl Law {
    /// The number of a place.
    pub fn draw(self, place: Place) -> f64 {
        let u = place.unit(0);
        match self {
            Law::Uniform(low, high) => low + (high - low) * u,
            Law::LogUniform(low, high) => low * (u * (high / low).ln()).exp(),
            Law::Normal(mean, deviation) => {
                mean + deviation * (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * place.unit(1)).cos()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draws(law: Law) -> Vec<f64> {
        (0..100_000).map(|index| law.draw(Place { seed: 7, index, entry: 1 })).collect()
    }

    /// Mean and standard deviation.
    fn moments(all: &[f64]) -> (f64, f64) {
        let count = all.len() as f64;
        let mean = all.iter().sum::<f64>() / count;
        (mean, (all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt())
    }

    #[test]
    fn draws_have_the_moments_of_their_law() {
        // Standard errors of 10⁵ draws: 1/√12/316 = 9e-4 of a mean of uniform numbers, 1/316 = 3e-3 of normal ones; five of them.
        let (mean, deviation) = moments(&draws(Law::Uniform(-1.0, 3.0)));
        assert!((mean - 1.0).abs() < 0.02 && (deviation - 4.0 / 12f64.sqrt()).abs() < 0.02, "{mean} {deviation}");
        let (mean, deviation) = moments(&draws(Law::Normal(2.0, 0.5)));
        assert!((mean - 2.0).abs() < 0.008 && (deviation - 0.5).abs() < 0.008, "{mean} {deviation}");
        let logarithms: Vec<f64> = draws(Law::LogUniform(1e-3, 1.0)).iter().map(|x| x.log10()).collect();
        let (mean, deviation) = moments(&logarithms);
        assert!((mean + 1.5).abs() < 0.015 && (deviation - 3.0 / 12f64.sqrt()).abs() < 0.015, "{mean} {deviation}");
    }

    #[test]
    fn neighbouring_places_are_independent_and_a_place_always_draws_the_same() {
        let at = |index, entry| Law::Uniform(-1.0, 1.0).draw(Place { seed: 7, index, entry });
        // The mean of 10⁵ products of independent numbers with a variance of 1/3 is 1/3/316 = 1e-3 from zero; five of that.
        let mean = |product: &dyn Fn(u64) -> f64| (0..100_000).map(product).sum::<f64>() / 1e5;
        assert!(mean(&|index| at(index, 0) * at(index + 1, 0)).abs() < 5e-3);
        assert!(mean(&|index| at(index, 0) * at(index, 1)).abs() < 5e-3);
        // Worked out apart, from the header of this file: sweeps of yesterday come out the same tomorrow.
        let drawn = |seed, index, entry| Law::Uniform(0.0, 1.0).draw(Place { seed, index, entry });
        assert_eq!([drawn(0, 0, 0), drawn(7, 123_456_789_012, 3)], [0.1296456182997474, 0.10101660174394256]);
    }
}

//! Random numbers of a scene: the seed decides all of them.

use crate::common::Numbers;
use nalgebra::Vector3;

/// The numbers of one scene.
pub struct Draw(Numbers);

impl Draw {
    /// The first numbers after a seed are much alike, so that some are left out.
    pub fn new(seed: u64) -> Self {
        let mut numbers = Numbers::new(seed.wrapping_mul(2_654_435_761).wrapping_add(97));
        for _ in 0..8 {
            let _ = numbers.next(0.0, 1.0);
        }
        Draw(numbers)
    }

    /// Between the bounds, rounded to seven digits, which scene files hold exactly.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        let number = self.0.next(low, high);
        format!("{number:.6e}").parse().unwrap_or(number).clamp(low, high)
    }

    /// Between the bounds, with an even distribution of its logarithm.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        let exponent = self.0.next(low.ln(), high.ln());
        format!("{:.6e}", exponent.exp()).parse().unwrap_or(low)
    }

    /// A whole number below `count`.
    pub fn index(&mut self, count: usize) -> usize {
        (self.0.next(0.0, count as f64) as usize).min(count - 1)
    }

    /// One of these.
    pub fn pick<T: Clone>(&mut self, among: &[T]) -> T {
        among[self.index(among.len())].clone()
    }

    /// True with this probability.
    pub fn coin(&mut self, probability: f64) -> bool {
        self.0.next(0.0, 1.0) < probability
    }

    /// Each entry between plus and minus `size`.
    pub fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.range(-size, size))
    }

    /// A restitution: none, all, or some.
    pub fn restitution(&mut self) -> f64 {
        match self.index(3) {
            0 => 0.0,
            1 => 1.0,
            _ => self.range(0.05, 0.95),
        }
    }
}

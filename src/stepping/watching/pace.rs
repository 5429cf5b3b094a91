//! The pace of a motion: how fast its fastest changes are, and how the pace grows.
//!
//! ```text
//!     Ω⁴ = Ω₀⁴ + Σ (q̇⁴ + q̈²)  [1/s⁴],     L = d/dt ln Ω = Σ (4 q̇³ q̈ + 2 q̈ q⃛) / (4 Ω⁴)  [1/s]
//! ```
//!
//! Its use: [`crate::length::reversible`].

use crate::watching::dynamics::Dynamics;
use catena_lobatto::plan::tree::Plan;
use catena_lobatto::stages::start::Start;

/// Pace of a motion that is nearly at rest [1/s].
const FLOOR: f64 = 1e-3;

/// The fastest fall of the pace over a step, `h₋ L`, that the rule is asked for: below −2/e it has no solution.
pub(crate) const STEEPEST: f64 = -0.6;

/// Pace of a motion and how it grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Ω [1/s].
    pub rate: f64,
    /// L [1/s].
    pub growth: f64,
}

impl Pace {
    /// The pace at the start of a step; `jerks` is room for the third derivatives.
    pub fn at(dynamics: &mut Dynamics, plan: &Plan, start: &Start, gravity: &[f64; 3], jerks: &mut [f64]) -> Self {
        dynamics.set(plan, start, gravity);
        dynamics.jerks(plan, start, jerks);
        let (mut power, mut slope) = (FLOOR.powi(4), 0.0);
        for ((rate, acceleration), jerk) in start.rates.iter().zip(dynamics.accelerations()).zip(jerks) {
            power += rate.powi(4) + acceleration.powi(2);
            slope += 4.0 * rate.powi(3) * acceleration + 2.0 * acceleration * *jerk;
        }
        Pace { rate: power.sqrt().sqrt(), growth: slope / (4.0 * power) }
    }

    /// The step after a step of length `before` (s).
    pub(crate) fn next(&self, before: f64) -> f64 {
        // Let x = ½ ln(h₊/h₋) and u = h₋ L: 2 x + u eˣ = 0.
        let u = (before * self.growth).max(STEEPEST);
        let mut x = 0.0_f64;
        for _ in 0..8 {
            let grown = u * x.exp();
            x -= (2.0 * x + grown) / (2.0 + grown);
        }
        before * (2.0 * x).exp()
    }

    /// `h Ω` in the middle of a step of length `step` from here.
    pub(crate) fn span(&self, step: f64) -> f64 {
        step * self.rate * (0.5 * step * self.growth).exp()
    }
}

//! A viscous damper along one degree of freedom.
//!
//! ```text
//!     τ = −c q̇          [N m] or [N]       c ≥ 0 [N m s/rad] or [N s/m]
//!     P = c q̇² ≥ 0      [W]                the power it turns into heat
//!     ∂τ/∂q̇ = −c
//! ```
//!
//! For a ball joint the freedom is one component of the angular velocity in the child's joint frame.
//!
//! Source: H. Goldstein, Classical Mechanics, section 1.5 (Rayleigh's dissipation function ½ c q̇²).

use crate::description::forces::JointDamper;

impl JointDamper {
    /// The effort on the child at a rate [rad/s or m/s].
    pub fn effort(&self, rate: f64) -> f64 {
        -self.coefficient * rate
    }

    /// The power turned into heat (W).
    pub fn dissipated_power(&self, rate: f64) -> f64 {
        self.coefficient * rate * rate
    }

    /// `∂τ/∂q̇`.
    pub fn rate_derivative(&self) -> f64 {
        -self.coefficient
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forces::differences::central;

    #[test]
    fn derivative_is_that_of_the_effort_and_power_is_effort_times_rate() {
        let damper = JointDamper { freedom: 0, coefficient: 0.7 };
        let slope = central(|rate| damper.effort(rate), 1.3);
        assert!((slope - damper.rate_derivative()).abs() < 1e-9, "{slope}");
        assert!((damper.dissipated_power(-1.3) + damper.effort(-1.3) * -1.3).abs() < 1e-15);
    }
}

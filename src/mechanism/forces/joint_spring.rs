//! A linear spring along one scalar joint coordinate.
//!
//! ```text
//!     τ = −k (q − q₀)        [N m] or [N]      k [N m/rad] or [N/m], q₀ [rad] or [m] where it is free of force
//!     V = ½ k (q − q₀)²      [J]
//!     ∂τ/∂q = −k
//! ```
//!
//! Angles count full turns: the spring of a joint that has turned once is wound up by 2π.
//!
//! Source: Hooke's law.

use crate::description::forces::JointSpring;

impl JointSpring {
    /// The effort on the child at a position (rad or m).
    pub fn effort(&self, position: f64) -> f64 {
        -self.stiffness * (position - self.rest)
    }

    /// The energy it stores (J).
    pub fn energy(&self, position: f64) -> f64 {
        0.5 * self.stiffness * (position - self.rest).powi(2)
    }

    /// `∂τ/∂q`.
    pub fn position_derivative(&self) -> f64 {
        -self.stiffness
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::closure::Coordinate;
    use crate::forces::differences::central;

    #[test]
    fn effort_is_minus_the_slope_of_the_energy_and_the_derivative_is_that_of_the_effort() {
        let coordinate = Coordinate { body: 0, position: 0, freedom: 0 };
        let spring = JointSpring { coordinate, stiffness: 3.2, rest: -0.4 };
        let slope = central(|position| spring.energy(position), 1.1);
        assert!((slope + spring.effort(1.1)).abs() < 1e-9, "{slope}");
        let slope = central(|position| spring.effort(position), 1.1);
        assert!((slope - spring.position_derivative()).abs() < 1e-9, "{slope}");
    }
}

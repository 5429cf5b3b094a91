//! A constant effort along one degree of freedom.
//!
//! ```text
//!     τ = constant           [N m] or [N]
//!     V = −τ q               [J]      along a scalar coordinate, where it has a potential
//!     P = τ q̇                [W]      about an axis of a ball joint, where it has none: its work depends on the path
//! ```
//!
//! Its derivatives are zero.
//!
//! Source: H. Goldstein, Classical Mechanics, section 1.4 (generalised forces).

use crate::description::forces::JointLoad;

impl JointLoad {
    /// The potential at a position of a scalar coordinate (J).
    pub fn potential(&self, position: f64) -> f64 {
        -self.effort * position
    }

    /// The power it puts in at a rate (W).
    pub fn power(&self, rate: f64) -> f64 {
        self.effort * rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forces::differences::central;

    #[test]
    fn effort_is_minus_the_slope_of_the_potential() {
        let load = JointLoad { freedom: 0, effort: 0.9 };
        assert!((central(|position| load.potential(position), 0.3) + load.effort).abs() < 1e-9);
    }
}

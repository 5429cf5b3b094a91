//! The energy that no step sees: what all forces on a mechanism do over the displacement that the iteration leaves of places.
//!
//! ```text
//!     F = Σ m |g| + Σ |τ| + Σ (|f| + |t|) + √(2 U Σ k)          [N; N m of joints that turn]
//!     W = F δ,    δ = 10⁻¹³ m                                    [J]
//! ```
//!
//! with efforts τ from outside and of loads, wrenches (f, t), springs that store U with stiffnesses k (`Σ k |Δ| ≤ √(2 U Σ k)`). It does not depend on where the height or the origin is 0, and is there where nothing moves: a kinetic energy is one of roundings
//! then, and no energy is small against it.

use catena_mechanism::description::mechanism::Mechanism;

/// δ: what roundings and the iteration leave of places (m; rad), a thousand roundings of a metre.
const LEFT: f64 = 1e-13;

/// Of the forces of a mechanism what does not change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pushes {
    /// Weights, loads and wrenches, added up [N or N m].
    constant: f64,
    /// Σ k [N/m or N m/rad].
    stiffness: f64,
}

impl Pushes {
    /// Those of a mechanism.
    pub fn of(mechanism: &Mechanism) -> Self {
        let forces = &mechanism.forces;
        let weight = mechanism.total_mass() * mechanism.gravity.norm();
        let loads: f64 = forces.joint_loads.iter().map(|load| load.effort.abs()).sum();
        let wrenches: f64 = forces.wrenches.iter().map(|wrench| wrench.force.norm() + wrench.torque.norm()).sum();
        let joints: f64 = forces.joint_springs.iter().map(|spring| spring.stiffness).sum();
        let points: f64 = forces.point_springs.iter().map(|spring| spring.stiffness).sum();
        Pushes { constant: weight + loads + wrenches, stiffness: joints + points }
    }

    /// F with springs that store so much (J), and efforts of this sum.
    pub fn with(&self, stored: f64, efforts: f64) -> f64 {
        self.constant + (2.0 * stored.max(0.0) * self.stiffness).sqrt() + efforts
    }
}

/// W (J) of forces F.
pub fn unseen(pushes: f64) -> f64 {
    LEFT * pushes
}

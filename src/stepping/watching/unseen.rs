//! The energy that no step sees: the work of all forces on a mechanism over the displacement that the iteration leaves in places.
//!
//! ```text
//!     F = Σ m |g| + Σ |τ| + Σ (|f| + |t|) + √(2 U Σ k)          [N; N m of joints that turn]
//!     W = F δ,    δ = 10⁻¹³ m                                    [J]
//! ```
//!
//! with efforts τ from outside and of loads, wrenches (f, t), springs that store U with stiffnesses k (`Σ k |Δ| ≤ √(2 U Σ k)`). It does not depend on
//! the zero of the height or the origin, and does not vanish at rest, where the kinetic energy is rounding and no scale.

use catena_mechanism::description::mechanism::Mechanism;

/// δ: the error of places from rounding and the iteration (m; rad), a thousand roundings of a metre.
const LEFT: f64 = 1e-13;

/// The constant part of the forces of a mechanism.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pushes {
    /// Weights, loads and wrenches, added up [N or N m].
    constant: f64,
    /// Σ k [N/m or N m/rad].
    stiffness: f64,
}

impl Pushes {
    /// The pushes of a mechanism.
    pub fn of(mechanism: &Mechanism) -> Self {
        let forces = &mechanism.forces;
        let weight = mechanism.total_mass() * mechanism.gravity.norm();
        let loads: f64 = forces.joint_loads.iter().map(|load| load.effort.abs()).sum();
        let wrenches: f64 = forces.wrenches.iter().map(|wrench| wrench.force.norm() + wrench.torque.norm()).sum();
        let joints: f64 = forces.joint_springs.iter().map(|spring| spring.stiffness).sum();
        let points: f64 = forces.point_springs.iter().map(|spring| spring.stiffness).sum();
        let changing: f64 = forces.joint_courses.iter().map(|load| load.effort.abs()).sum();
        let turning: f64 = forces.link_loads.iter().map(|load| load.force.norm() + load.torque.norm()).sum();
        Pushes { constant: weight + loads + wrenches + changing + turning, stiffness: joints + points }
    }

    /// F with springs that store this energy (J), and efforts of this sum.
    pub fn with(&self, stored: f64, efforts: f64) -> f64 {
        self.constant + (2.0 * stored.max(0.0) * self.stiffness).sqrt() + efforts
    }
}

/// W (J) of forces F.
pub fn unseen(pushes: f64) -> f64 {
    LEFT * pushes
}

#[cfg(test)]
mod tests {
    use super::*;
    use catena_mechanism::description::closure::Coordinate;
    use catena_mechanism::description::forces::{JointLoad, JointSpring};
    use catena_mechanism::description::joint::{Joint, JointKind, Pose};
    use catena_mechanism::description::mechanism::Body;
    use nalgebra::Vector3;

    #[test]
    fn forces_of_two_slides_add_up_and_springs_push_no_more_than_what_they_store_says() {
        let slide = |name: &str| Body {
            name: name.into(),
            parent: None,
            mass: 2.0,
            inertia: Vector3::repeat(0.1),
            joint: Joint::new(name, JointKind::Prismatic, Pose::translation(0.0, 0.0, 1e3), Pose::identity()),
        };
        let gravity = Vector3::new(0.0, 0.0, -10.0);
        let mut slides = Mechanism::new("slides", gravity, vec![slide("a"), slide("b")]).expect("two bodies");
        slides.forces.joint_loads.push(JointLoad { freedom: 0, effort: -3.0 });
        assert_eq!(Pushes::of(&slides).with(0.0, 5.0), 2.0 * 20.0 + 3.0 + 5.0);
        for (body, stiffness) in [(0, 100.0), (1, 300.0)] {
            let coordinate = Coordinate { body, position: body, freedom: body };
            slides.forces.joint_springs.push(JointSpring { coordinate, stiffness, rest: 0.0 });
        }
        // Both are pressed by 0.1 m: exactly 10 N and 30 N. Springs at 0.2 and 0.1 m: 50 N, and the estimate adds at most 3 N more.
        let pushes = Pushes::of(&slides);
        assert!((pushes.with(0.5 * 400.0 * 0.01, 0.0) - 83.0).abs() < 1e-12);
        let said = pushes.with(0.5 * (100.0 * 0.04 + 300.0 * 0.01), 0.0) - 43.0;
        assert!((50.0..53.0).contains(&said), "{said}");
    }
}

//! A constant force at a point of a body and a constant torque on it, both with the directions of the world.
//!
//! ```text
//!     r = R p [m],   P = x + r                        p: the point in the body frame
//!     f = F [N],     n = N + r × F [N m]              about the centre of mass x
//!     V = −F·P [J]                                    the force has a potential
//!     P = N·ω [W]                                     the torque has none: its work depends on the path
//!     ∂n/∂φ = F̂ r̂                                    φ: a small rotation of the body in the world
//! ```
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008), section 2.4.

use crate::description::body_state::BodyState;
use crate::description::forces::Wrench;
use crate::ground::matrices::times;
use nalgebra::{Matrix3, Vector3};

impl Wrench {
    /// Torque about the centre of mass [N m].
    pub fn torque_about_center(&self, body: &BodyState) -> Vector3<f64> {
        self.torque + times(&body.rotation, &self.point).cross(&self.force)
    }

    /// The potential of the force (J), zero for a point at the world origin.
    pub fn potential(&self, body: &BodyState) -> f64 {
        -self.force.dot(&(body.position + times(&body.rotation, &self.point)))
    }

    /// The power of the torque (W).
    pub fn power(&self, angular_velocity: &Vector3<f64>) -> f64 {
        self.torque.dot(angular_velocity)
    }

    /// `∂n/∂φ`, the derivative of the torque about the centre of mass by a small rotation [N m].
    pub fn rotation_derivative(&self, body: &BodyState) -> Matrix3<f64> {
        self.force.cross_matrix() * (body.rotation * self.point).cross_matrix()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::body_state::WORLD;
    use crate::forces::differences::central_vector;
    use nalgebra::Rotation3;

    fn pushed() -> (Wrench, BodyState) {
        let wrench = Wrench {
            body: 0,
            point: Vector3::new(0.2, -0.3, 0.5),
            force: Vector3::new(1.0, 2.0, -3.0),
            torque: Vector3::new(0.3, 0.1, 0.2),
        };
        let rotation = Rotation3::new(Vector3::new(0.4, -0.7, 0.2)).into_inner();
        (wrench, BodyState { rotation, ..WORLD })
    }

    fn turned(body: &BodyState, by: Vector3<f64>) -> BodyState {
        BodyState { rotation: Rotation3::new(by).matrix() * body.rotation, ..*body }
    }

    #[test]
    fn derivative_by_rotation_is_that_of_the_torque() {
        let (wrench, body) = pushed();
        let numeric = central_vector(|by| wrench.torque_about_center(&turned(&body, by)), Vector3::zeros());
        assert!((wrench.rotation_derivative(&body) - numeric).amax() < 1e-8, "{numeric}");
    }

    #[test]
    fn force_is_minus_the_slope_of_the_potential() {
        let (wrench, body) = pushed();
        let moved = |by: Vector3<f64>| Vector3::repeat(wrench.potential(&BodyState { position: by, ..body }));
        let slope = central_vector(moved, Vector3::zeros()).row(0).transpose();
        assert!((slope + wrench.force).amax() < 1e-8, "{slope}");
        let turns = central_vector(|by| Vector3::repeat(wrench.potential(&turned(&body, by))), Vector3::zeros());
        let lever = (body.rotation * wrench.point).cross(&wrench.force);
        assert!((turns.row(0).transpose() + lever).amax() < 1e-8, "{turns}");
    }
}

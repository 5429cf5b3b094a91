//! How fast the gap of a round shape on a fixed plane closes: a wheel that rolls on a floor closes no gap, however fast it turns.
//!
//! The plane has the normal n, the shape the axis a. No motion along the plane and no turning about a or n moves a point of the shape nearer. The
//! centre o of the shape moves with `v_o`, and its farthest point is R from it (m):
//!
//! ```text
//!     V = |n · v_o| + |ε̇| R  [m/s],     ε̇ = ω · (a × n)/|a × n|       the tilt of the axis, sin ε = n · a
//!     φ = n · o ± h sin ε − ρ cos ε,   φ̇ = n · v_o + (± h cos ε + ρ sin ε) ε̇      of a rim of radius ρ, h from o (m)
//! ```
//!
//! Where the shape all but stands on its end, every turning across the normal counts. The bound is for pairs with a closed contact: the other rim of a wheel
//! with a camber is micrometres above the floor for as long as it rolls.

use crate::geometry::{PairGeometry, Revolved};
use crate::instant::holding::revolving::without_spin;
use crate::mechanism::description::body_state::BodyState;
use nalgebra::Vector3;

/// The direction `a × n` is known while it is longer than this.
const SLANTED: f64 = 0.1;

/// A round shape of a body on a plane of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rolling {
    /// Its body.
    pub body: usize,
    /// Unit normal out of the plane.
    pub normal: Vector3<f64>,
    /// The shape and its axis.
    pub shape: Revolved,
    pub axis: Vector3<f64>,
}

impl Rolling {
    /// The pair of bodies as a round shape on a plane of the world, if it is one.
    pub fn of(bodies: [Option<usize>; 2], geometry: &PairGeometry) -> Option<Self> {
        let (plane, normal) = geometry.half_space()?;
        let shape = geometry.revolved()[1 - plane]?;
        let body = bodies[1 - plane].filter(|_| bodies[plane].is_none())?;
        Some(Rolling { body, normal, axis: shape.axis?, shape })
    }

    /// n (n · v_o) and the turning of its body that tilts the axis, in this state [m/s, rad/s].
    pub fn motion(&self, body: &BodyState) -> [Vector3<f64>; 2] {
        let Rolling { normal, shape, axis, .. } = self;
        let (moving, turning) = (without_spin(shape, body).velocity, body.angular_velocity);
        let tilting = match (body.rotation * axis).cross(normal).try_normalize(SLANTED) {
            Some(across) => across * across.dot(&turning),
            None => turning - normal * normal.dot(&turning),
        };
        [normal * normal.dot(&moving), tilting]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::scenes::Random;
    use nalgebra::Rotation3;

    /// A wheel of radius 0.3 m and width 0.2 m, away from the centre of mass of its body, on a slanted plane.
    fn wheel() -> Rolling {
        let normal = Vector3::new(0.2, -0.1, 1.0).normalize();
        let (centre, axis) = (Vector3::new(0.05, 0.4, -0.02), Vector3::new(0.3, 0.9, 0.1).normalize());
        let shape = Revolved { centre, axis: Some(axis), reach: 0.3_f64.hypot(0.1) };
        Rolling { body: 0, normal, shape, axis }
    }

    fn body(rotation: Rotation3<f64>, velocity: Vector3<f64>, angular_velocity: Vector3<f64>) -> BodyState {
        BodyState { position: Vector3::zeros(), rotation: rotation.into_inner(), velocity, angular_velocity }
    }

    #[test]
    fn a_wheel_that_rolls_and_steers_on_a_plane_closes_no_gap() {
        let Rolling { normal, shape, axis, .. } = wheel();
        let rotation = Rotation3::new(Vector3::new(0.4, -0.2, 0.9));
        let (axis, centre) = (rotation * axis, rotation * shape.centre);
        // It turns about its axis and the normal, and its centre moves along the plane.
        let turning = axis * 20.0 + normal * 3.0;
        let along = normal.cross(&Vector3::new(1.0, 2.0, 3.0));
        let moves = body(rotation, along - turning.cross(&centre), turning);
        let [moving, tilting] = wheel().motion(&moves);
        // Some roundings of 20 rad/s.
        assert!(moving.norm() < 1e-13 && tilting.norm() < 1e-13, "{moving} {tilting}");
    }

    #[test]
    fn the_gap_of_no_rim_changes_faster_than_the_motion_of_the_axis_says() {
        let (mut random, wheel) = (Random::new(3), wheel());
        let (Rolling { normal, axis, .. }, Revolved { centre, reach, .. }) = (wheel, wheel.shape);
        let mut vector = |size: f64| Vector3::from_fn(|_, _| size * random.signed());
        let mut closest = 0.0_f64;
        for _ in 0..2000 {
            let (rotation, velocity, turning) = (Rotation3::new(vector(3.0)), vector(1.0), vector(9.0));
            let state = body(rotation, velocity, turning);
            let gap = |time: f64, end: f64| {
                let turned = Rotation3::new(turning * time) * rotation;
                let along = turned * axis;
                let middle = velocity * time + turned * (centre + axis * (0.1 * end));
                normal.dot(&middle) - 0.3 * along.cross(&normal).norm()
            };
            let [moving, tilting] = wheel.motion(&state);
            let bound = moving.norm() + reach * tilting.norm();
            for end in [-1.0, 1.0] {
                let rate = (gap(1e-6, end) - gap(-1e-6, end)).abs() / 2e-6;
                // Central differences are off by some 1e-9.
                assert!(rate <= bound + 1e-8, "{rate} {bound}");
                closest = closest.max(rate / bound);
            }
        }
        assert!(closest > 0.9, "the bound is near: {closest}");
    }
}

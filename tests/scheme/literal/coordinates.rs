//! The coordinates of the literal scheme: twelve numbers a body, its place and the rows of its rotation matrix.
//!
//! ```text
//!     q = (x, R) ∈ R¹²  for every body,      q̇ = (v, ω̂ R)
//! ```

use catena::mechanism::description::body_state::BodyState;
use nalgebra::{DVector, Matrix3, Vector3};
/// Coordinates of one body: three of position, nine of rotation.
pub(crate) const BODY_COORDINATES: usize = 12;

/// `q` and `q̇` (12 n each) of a state: `Ṙ = ω̂ R` with the angular velocity in the world.
pub fn coordinates(bodies: &[BodyState]) -> (DVector<f64>, DVector<f64>) {
    let size = BODY_COORDINATES * bodies.len();
    let (mut q, mut velocity) = (DVector::zeros(size), DVector::zeros(size));
    for (index, body) in bodies.iter().enumerate() {
        let first = BODY_COORDINATES * index;
        let rotation_rate = body.angular_velocity.cross_matrix() * body.rotation;
        q.rows_mut(first, 3).copy_from(&body.position);
        q.rows_mut(first + 3, 9).copy_from_slice(body.rotation.as_slice());
        velocity.rows_mut(first, 3).copy_from(&body.velocity);
        velocity.rows_mut(first + 3, 9).copy_from_slice(rotation_rate.as_slice());
    }
    (q, velocity)
}

/// The state with coordinates `q` and velocities `q̇` (12 n each); the inverse of [`coordinates`] on the constraints.
pub fn body_states(q: &DVector<f64>, velocity: &DVector<f64>) -> Vec<BodyState> {
    (0..q.len() / BODY_COORDINATES)
        .map(|index| {
            let first = BODY_COORDINATES * index;
            let rotation = Matrix3::from_column_slice(&q.as_slice()[first + 3..first + 12]);
            let rotation_rate = Matrix3::from_column_slice(&velocity.as_slice()[first + 3..first + 12]);
            let spin = rotation_rate * rotation.transpose();
            BodyState {
                position: q.fixed_rows::<3>(first).into_owned(),
                rotation,
                velocity: velocity.fixed_rows::<3>(first).into_owned(),
                angular_velocity: 0.5
                    * Vector3::new(
                        spin[(2, 1)] - spin[(1, 2)],
                        spin[(0, 2)] - spin[(2, 0)],
                        spin[(1, 0)] - spin[(0, 1)],
                    ),
            }
        })
        .collect()
}

//! The pose and the velocity of one body in maximal coordinates.

use nalgebra::{Matrix3, Vector3};

/// The maximal-coordinate state of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// Centre of mass in the world (m).
    pub position: Vector3<f64>,
    /// Body axes in the world, as columns.
    pub rotation: Matrix3<f64>,
    /// Velocity of the centre of mass in the world [m/s].
    pub velocity: Vector3<f64>,
    /// Angular velocity in the world [rad/s].
    pub angular_velocity: Vector3<f64>,
}

/// The state of the world seen as a body.
pub const WORLD: BodyState = BodyState {
    position: Vector3::new(0.0, 0.0, 0.0),
    rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    velocity: Vector3::new(0.0, 0.0, 0.0),
    angular_velocity: Vector3::new(0.0, 0.0, 0.0),
};

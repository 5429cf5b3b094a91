//! The motion of a shape of revolution as a set of points: without its turning about its own axis, which closes no gap.
//!
//! ```text
//!     o = c + R o₀,   v_o = v + ω × (o − c),   ω' = ω − a (a · ω),   ω' = 0 for a ball
//! ```
//!
//! o is the middle of the shape (m), a its axis, a unit vector in the world; c, v and ω are of its body. A shape that moves with v_o at o and turns with ω' covers the same
//! points at every instant, and so its distance from any other shape is the same. Without this a roller that turns at 100 rad/s closes gaps at the speed of its rim.

use crate::geometry::Revolved;
use crate::mechanism::description::body_state::BodyState;
use nalgebra::Vector3;

/// The body of a shape of revolution as it moves without that turning, with the middle of the shape in the place of its centre of mass.
pub(crate) fn without_spin(shape: &Revolved, body: &BodyState) -> BodyState {
    let (centre, turning) = (body.rotation * shape.centre, body.angular_velocity);
    let angular_velocity = shape.axis.map_or(Vector3::zeros(), |axis| {
        let axis = body.rotation * axis;
        turning - axis * axis.dot(&turning)
    });
    BodyState {
        position: body.position + centre,
        velocity: body.velocity + turning.cross(&centre),
        angular_velocity,
        ..*body
    }
}

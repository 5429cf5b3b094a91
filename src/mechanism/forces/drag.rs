//! Drag of a body in a fluid at rest: a force against the velocity of a point, and a torque against its turning.
//!
//! ```text
//!     v = v_x + ω × R p [m/s]                          p: the point in the body frame
//!     f = −(c₁ + c₂ |v|) v [N],   n = −(d₁ + d₂ |ω|) ω + R p × f [N m]      about the centre of mass
//!     P = f·v + n₀·ω ≤ 0 [W]                           turned into heat;  n₀: the torque besides that of f
//! ```
//!
//! Source: G. K. Batchelor, An Introduction to Fluid Dynamics, Cambridge 1967, sections 4.9 and 5.11 (slow and fast motion).

use crate::description::body_state::BodyState;
use crate::description::forces::Drag;
use crate::ground::matrices::times;
use nalgebra::Vector3;

impl Drag {
    /// Force (N), and torque about the centre of mass [N m], in the world.
    pub fn wrench(&self, body: &BodyState) -> (Vector3<f64>, Vector3<f64>) {
        let arm = times(&body.rotation, &self.point);
        let velocity = body.velocity + body.angular_velocity.cross(&arm);
        let force = velocity * -(self.linear + self.quadratic * velocity.norm());
        let spin = body.angular_velocity;
        (force, spin * -(self.angular_linear + self.angular_quadratic * spin.norm()) + arm.cross(&force))
    }

    /// The power that it turns into heat (W).
    pub fn dissipated_power(&self, body: &BodyState) -> f64 {
        let (force, torque) = self.wrench(body);
        -(force.dot(&body.velocity) + torque.dot(&body.angular_velocity))
    }
}

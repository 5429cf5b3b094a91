//! A force at a point of a body and a torque on it, with the directions of the world or of the body, which may change in time.
//!
//! ```text
//!     r = R p [m],   v = v_x + ω × r [m/s]            p: the point in the body frame
//!     f = c(t) Q F [N],   n = c(t) Q N + r × f [N m]  about the centre of mass;   Q = R where they turn with the body, else 1
//!     P = f·v + c(t) Q N·ω [W]                        without potential: all of its work is put in
//! ```
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008), section 2.4.

use crate::description::body_state::BodyState;
use crate::description::forces::LinkLoad;
use crate::ground::matrices::times;
use nalgebra::Vector3;

impl LinkLoad {
    /// Force (N) and torque [N m] at the point, in the world, where the factor over time is `factor`.
    pub fn at_point(&self, factor: f64, body: &BodyState) -> (Vector3<f64>, Vector3<f64>) {
        let turned = |own: &Vector3<f64>| if self.turns { times(&body.rotation, own) } else { *own };
        (turned(&self.force) * factor, turned(&self.torque) * factor)
    }

    /// Force (N), and torque about the centre of mass [N m], in the world.
    pub fn wrench(&self, factor: f64, body: &BodyState) -> (Vector3<f64>, Vector3<f64>) {
        let (force, torque) = self.at_point(factor, body);
        (force, torque + times(&body.rotation, &self.point).cross(&force))
    }

    /// The power that it puts in (W).
    pub fn power(&self, factor: f64, body: &BodyState) -> f64 {
        let (force, torque) = self.wrench(factor, body);
        force.dot(&body.velocity) + torque.dot(&body.angular_velocity)
    }
}

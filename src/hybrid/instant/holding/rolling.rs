//! How fast the gap of a round shape on a fixed plane closes: a wheel that rolls on a floor closes no gap, however fast it turns.
//!
//! The plane has the normal n, the shape the axis a. No motion along the plane and no turning about a or n moves a point of the shape nearer. The
//! centre o of the shape moves with `v_o`, and its farthest point is R from it (m):
//!
//! ```text
//!     V = |n · v_o| + |(1 − n nᵀ)(1 − a aᵀ) ω| R  [m/s]
//!     φ = n · o ± h sin ε − ρ cos ε,   φ̇ = n · v_o + (± h cos ε + ρ sin ε) ε̇      of a rim of radius ρ, h from o (m);   sin ε = n · a
//! ```
//!
//! The tilt ε changes by `|ε̇| = |ω · (a × n)|/|a × n|`, which is at most the second term over R, because `a × n` is across both. The bound is for pairs
//! with a closed contact: the other rim of a wheel with a camber is micrometres above the floor for as long as it rolls.

use crate::geometry::RoundOnPlane;
use crate::mechanism::description::body_state::BodyState;
use nalgebra::Vector3;

/// A round shape of a body on a plane of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rolling {
    /// Its body.
    pub body: usize,
    /// Its axis, its centre and the plane.
    pub shape: RoundOnPlane,
}

impl Rolling {
    /// The pair of bodies as a round shape on a plane of the world, if it is one.
    pub fn of(bodies: [Option<usize>; 2], shape: Option<RoundOnPlane>) -> Option<Self> {
        let shape = shape?;
        let [round, plane] = [shape.side, 1 - shape.side].map(|side| bodies[side]);
        round.filter(|_| plane.is_none()).map(|body| Rolling { body, shape })
    }

    /// n (n · v_o) and `(1 − n nᵀ)(1 − a aᵀ) ω` of its body in this state [m/s, rad/s].
    pub fn motion(&self, body: &BodyState) -> [Vector3<f64>; 2] {
        let RoundOnPlane { normal, centre, axis, .. } = &self.shape;
        let (centre, axis) = (body.rotation * centre, body.rotation * axis);
        let turning = body.angular_velocity;
        let moving = body.velocity + turning.cross(&centre);
        let across = turning - axis * axis.dot(&turning);
        [normal * normal.dot(&moving), across - normal * normal.dot(&across)]
    }
}

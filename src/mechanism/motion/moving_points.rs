//! Points and vectors that are fixed in bodies, with their first and second derivatives in time.
//!
//! ```text
//!     P = x + r,   Ṗ = ẋ + ω × r,   P̈ = ẍ + ω̇ × r + ω × (ω × r)           x, ẋ, ẍ of the centre of mass (m, m/s, m/s²), r from it to P (m)
//! ```

use crate::description::body_state::BodyState;
use crate::ground::smooth::{Jet, Triple};
use nalgebra::Vector3;

/// A point of a body with these accelerations, linear and angular, and its derivatives.
pub(crate) fn moving_point(
    body: &BodyState,
    [linear, angular]: [&Vector3<f64>; 2],
    point: &Vector3<f64>,
) -> Triple<Jet> {
    let arm = turned(body, angular, &(point - body.position));
    let center = [body.position, body.velocity, *linear];
    jets([center[0] + arm[0], center[1] + arm[1], center[2] + arm[2]])
}

/// A vector fixed in a body with this angular acceleration [rad/s²], and its first and second derivatives.
pub(crate) fn turned(body: &BodyState, angular: &Vector3<f64>, arm: &Vector3<f64>) -> [Vector3<f64>; 3] {
    let rate = body.angular_velocity.cross(arm);
    [*arm, rate, angular.cross(arm) + body.angular_velocity.cross(&rate)]
}

/// A vector with its derivatives as jets.
pub(crate) fn jets([value, rate, second]: [Vector3<f64>; 3]) -> Triple<Jet> {
    Triple([0, 1, 2].map(|i| Jet { value: value[i], rate: rate[i], second: second[i] }))
}

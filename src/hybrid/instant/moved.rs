//! How far a body moves between two places of it, and beside its way from one to the other.
//!
//! ```text
//!     |Δp| ≤ |Δx| + R |ΔR|/√2                                                    p: a point of it within the reach R of its centre of mass x (m)
//!     beside the way of δ seconds:  ≤ ½ δ (F max(|v₀|, |v₁|) + C |v₁ − v₀|)      F = 1.25,  C = 0.5;  v: v or ω at its ends [m/s or rad/s]
//! ```
//!
//! |ΔR|/√2 is the chord `2 sin(φ/2)` of a turn by φ.

use crate::mechanism::description::body_state::BodyState;
use nalgebra::Vector3;
use std::f64::consts::FRAC_1_SQRT_2;

/// F: bodies may be faster between two instants than at them by this factor.
pub const FASTER: f64 = 1.25;
/// C: they may also be faster by this part of the change of their velocity from one to the other.
pub const CHANGING: f64 = 0.5;

/// How far a body has moved: its centre of mass, and by a turn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moved {
    /// m.
    pub place: f64,
    /// |ΔR|/√2, at most the angle (rad).
    pub turn: f64,
}

impl Moved {
    /// Between two places of a body.
    pub fn between(before: &BodyState, now: &BodyState) -> Self {
        let turn = (now.rotation - before.rotation).norm() * FRAC_1_SQRT_2;
        Moved { place: (now.position - before.position).norm(), turn }
    }

    /// The same, and beside the way to the second place of so many seconds from a third one.
    #[must_use]
    pub fn with_way(self, from: &BodyState, now: &BodyState, long: f64) -> Self {
        let beside = |before: &Vector3<f64>, after: &Vector3<f64>| {
            0.5 * long * (FASTER * before.norm().max(after.norm()) + CHANGING * (after - before).norm())
        };
        Moved {
            place: self.place + beside(&from.velocity, &now.velocity),
            turn: self.turn + beside(&from.angular_velocity, &now.angular_velocity),
        }
    }

    /// The larger ones of both.
    #[must_use]
    pub fn most(self, other: Self) -> Self {
        Moved { place: self.place.max(other.place), turn: self.turn.max(other.turn) }
    }

    /// The most that a point within a reach (m) has moved (m).
    pub fn of_reach(self, reach: f64) -> f64 {
        self.place + if self.turn > 0.0 { self.turn * reach } else { 0.0 }
    }
}

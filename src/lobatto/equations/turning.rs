//! How the direction of friction follows a slip from one iterate to the next.
//!
//! If friction is large enough to stop a slip within the step, a small error of its direction t is a large error of the slip across t, and an iterate
//! with the direction of that slip is further off. So t is an unknown of its own, the angle φ, and that the slip has its direction is an equation.
//! Let `m = n × t` and `ρ = |t · u|`. Newton's method for both is
//!
//! ```text
//!     friction    μ Λ (t + m dφ),        m · u = ρ dφ       =>       dφ = m · (u + δu)/ρ
//! ```
//!
//! In the linear system this adds `R = μ Λ/ρ` times the part of the slip `u + δu` across t. The next direction is the direction of `ρ t + (m · u) m`,
//! with ρ of the iterate before. The ρ of this iterate would give the direction of u itself. That direction is taken if both speeds are alike: always
//! near the solution, and soon if friction is slow to turn a slip.
//!
//! The first iteration has no multipliers, and cannot say how t turns. Unless the slip agrees with t after it, t stays for the second.
//!
//! This is done in steps that begin without slip or with a slow one. Other steps would let it find solutions of steps that are too long, which do not
//! belong to the motion.
//!
//! Source: Newton's method in polar coordinates of `u + c t = w`, whose solution has the direction of w however small |u| is beside c.

use nalgebra::Vector3;

/// After the first iteration a slip that is off by no more than this (rad) agrees with t.
const AGREES: f64 = 1e-2;
/// Speeds along t, of two iterates, of which neither is larger by more than this factor are alike.
const ALIKE: f64 = 2.0;
/// After this number of iterations t has the direction of the slip.
const PATIENCE: usize = 12;

/// Memory of a stage.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Followed {
    /// `t · u` of the latest iterate [m/s].
    pub speed: f64,
    /// Whether t is not yet the direction of the slip.
    pub lags: bool,
}

impl Followed {
    /// The next direction, for the latest one, the normal and the slip after `iterations` iterations (at least one); `None` if it is the direction of
    /// the slip.
    pub fn turn(
        &mut self,
        iterations: usize,
        latest: &Vector3<f64>,
        normal: &Vector3<f64>,
        slip: &Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        if iterations > PATIENCE {
            return None;
        }
        let along = (latest - normal * normal.dot(latest)).try_normalize(0.0)?;
        let speed = along.dot(slip);
        // An iteration that runs away ends without a direction.
        if !(speed.is_finite() && self.speed.is_finite()) {
            return None;
        }
        let across = slip - along * speed;
        let turned = if iterations == 1 {
            (across.norm() > AGREES * speed.abs()).then_some(along)
        } else {
            let (ratio, before) = (speed / self.speed, self.speed.abs());
            let alike = (1.0 / ALIKE..=ALIKE).contains(&ratio) || before == 0.0;
            let towards = along * speed.clamp(before / ALIKE, before * ALIKE) + across;
            if alike { None } else { towards.try_normalize(0.0) }
        };
        self.lags = turned.is_some();
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_that_is_no_number_has_no_next_direction_and_does_not_panic() {
        for (speed, slip) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::INFINITY, 1.0), (1.0, f64::INFINITY)] {
            let mut followed = Followed { speed, lags: true };
            for iterations in 1..=PATIENCE {
                let slip = Vector3::new(slip, 1.0, 0.0);
                assert_eq!(followed.turn(iterations, &Vector3::x(), &Vector3::z(), &slip), None);
            }
        }
    }
}

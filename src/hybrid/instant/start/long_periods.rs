//! Motors whose effort is held for a period in which it more than reverses the motion that it damps.
//!
//! ```text
//!     v_{k+1} = v_k + T Y u_k,   u_k = −kd v_k − kp q_k       T: period (s);  Y: rate of the joint by a unit impulse [1/(kg m²) or 1/kg]
//!     |z| > 1 for a root of its characteristic polynomial if   Y kd T > 2,      whatever kp is
//! ```
//!
//! Other motors and dampers move other joints: the largest eigenvalue of a symmetric matrix is no less than its entries on the diagonal, so that the motion grows
//! with them, too. A wheel on a floor moves more than its own inertia: mechanisms that may touch are left out.
//!
//! Source: E. I. Jury, Theory and Application of the z-Transform Method (1964), for two roots inside the unit circle.

use crate::instant::dynamics::response::Response;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;

/// A motor whose period is too long for its damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LongPeriod {
    /// The body behind its joint.
    pub body: usize,
    /// Its period, and the longest one with which its motion does not grow (s).
    pub period: f64,
    pub longest: f64,
}

/// The motors with such a period at a state.
pub fn long_periods(mechanism: &Mechanism, state: &State) -> Vec<LongPeriod> {
    let damps = |period: f64, damping: f64| period > 0.0 && damping > 0.0;
    let motors = &mechanism.nonsmooth.motors;
    let sampled: Vec<_> = motors.iter().filter(|motor| damps(motor.period, motor.law.gains().1)).collect();
    if sampled.is_empty() || !mechanism.nonsmooth.pairs.is_empty() {
        return Vec::new();
    }
    let rates = Response::new(mechanism).diagonal(state, sampled.iter().map(|motor| motor.coordinate.freedom));
    let found = sampled.iter().zip(rates).map(|(motor, rate)| LongPeriod {
        body: motor.coordinate.body,
        period: motor.period,
        longest: 2.0 / (rate * motor.law.gains().1),
    });
    found.filter(|found| found.period > found.longest).collect()
}

//! Runs that begin between the ticks of sampled motors.
//!
//! ```text
//!     τ(t) = u(q_k, q̇_k)  for t_k ≤ t < t_{k+1},   t_k = k T        T: the period (s)
//! ```
//!
//! A run that begins at `t_k < t < t_{k+1}` knows no state at t_k: it works out the effort at t, and is not what a run through t is until t_{k+1}.

use crate::mechanism::description::mechanism::Mechanism;

/// A tick that is off by less than this part of the period is rounded.
const ROUNDING: f64 = 1e-9;

/// A line for each period whose motors begin between ticks at this time (s).
pub(crate) fn between_ticks(mechanism: &Mechanism, begin: f64) -> Vec<String> {
    let mut periods: Vec<(f64, Vec<&str>)> = Vec::new();
    for motor in &mechanism.nonsmooth.motors {
        if motor.period > 0.0 && begin - (motor.next_instant(begin) - motor.period) > ROUNDING * motor.period {
            let joint = mechanism.joint_of_freedom(motor.coordinate.freedom);
            match periods.iter_mut().find(|(period, _)| *period == motor.period) {
                Some((_, joints)) => joints.push(joint),
                None => periods.push((motor.period, vec![joint])),
            }
        }
    }
    let line = |(period, joints): &(f64, Vec<&str>)| {
        let (first, more) = (joints.first().copied().unwrap_or_default(), joints.len() - 1);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!(
            "the motor of joint {first:?}{more} has a period of {period} s, and the run begins between its ticks, at t = {begin} s: its effort \
             is worked out anew there, and is not that of the run before until the next tick; begin at a multiple of the period"
        )
    };
    periods.iter().map(line).collect()
}

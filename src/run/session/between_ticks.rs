//! Runs that begin between the ticks of sampled motors.
//!
//! ```text
//!     τ(t) = u(q_k, q̇_k)  for t_k ≤ t < t_{k+1},   t_k = k T        T: the period (s)
//! ```
//!
//! A run that begins at `t_k < t < t_{k+1}` knows no state at t_k. It goes on with the effort of the run before where a state or a log tells it. Otherwise
//! it works out the effort at t, and is not what a run through t is until t_{k+1}.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::{HeldEffort, Motor};

/// Lets the motors that are between ticks at the start of a run (s) hold these efforts until their next ticks, an entry a motor; whether any does.
pub(crate) fn hold(motors: &mut [Motor], efforts: &[Option<f64>], since: f64) -> bool {
    let mut any = false;
    for (motor, effort) in motors.iter_mut().zip(efforts) {
        motor.held = effort.filter(|_| motor.is_between_ticks(since)).map(|effort| HeldEffort { since, effort });
        any |= motor.held.is_some();
    }
    any
}

/// A line for each period whose motors begin between ticks at this time (s), and whose held effort is not known.
pub(crate) fn between_ticks(mechanism: &Mechanism, begin: f64) -> Vec<String> {
    let mut periods: Vec<(f64, Vec<&str>)> = Vec::new();
    for motor in &mechanism.nonsmooth.motors {
        if motor.is_between_ticks(begin) && motor.held_at(begin).is_none() {
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
             is worked out anew there, and is not that of the run before until the next tick; begin at a multiple of the period, or go on from a \
             state or a log with motors"
        )
    };
    periods.iter().map(line).collect()
}

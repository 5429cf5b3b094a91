//! Robots that an impact has stopped but for roundings of their rates stand still.
//!
//! ```text
//!     |q̇_i| ≤ ε V for all freedoms i of a robot ─▶ q̇ = 0        V: the largest rate that the impact has changed, before it;  ε = 1e-13
//! ```
//!
//! The forces between such bodies would be roundings of roundings if no load acts on them. Contacts would slip, open and close by `Ẇ q̇` of
//! 1e-28 m/s².

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;

/// ε. Impulses are the solution of a system, as the forces of contacts are.
const STOPPED: f64 = 1e-13;

/// Stops the robots whose rates an impact has changed from these to roundings.
pub(super) fn stop_roundings(whole: &Mechanism, state: &mut State, before: &[f64]) {
    let changed = state.velocity.iter().zip(before).filter(|(rate, before)| rate != before);
    let rest = STOPPED * changed.map(|(_, before)| before.abs()).fold(0.0, f64::max);
    for root in (0..whole.bodies.len()).filter(|&body| whole.bodies[body].parent.is_none()) {
        let robot = whole.subtree(root);
        let [first, last] = [root, robot.end - 1].map(|body| whole.bodies[body].joint.velocity_range());
        let freedoms = first.start..last.end;
        let rates = &mut state.velocity[freedoms.clone()];
        if rates != &before[freedoms] && rates.iter().all(|rate| rate.abs() <= rest) {
            rates.fill(0.0);
        }
    }
}

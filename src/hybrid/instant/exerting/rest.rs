//! Whether a mechanism starts at rest in equilibrium, so that it stays where it is.
//!
//! All velocities are zero, and with all forces and closures no body accelerates: to rounding, which is for each body
//!
//! ```text
//!     |a|, k |α| ≤ ε (|g| + |F|/m)        k = (½ tr J / m)^½
//! ```
//!
//! with its acceleration `a` [m/s²], angular acceleration `α` [rad/s²], the force `F` (N) of springs and loads on it, its mass `m` (kg), and radius
//! of gyration `k` (m). A body whose accelerations are within that rounding is at rest for this purpose. The largest entry of each vector counts,
//! which is finite, and which is not zero although its square may be. A body with inertia but no mass has no `k`: it must not turn at all.
//!
//! An unstable equilibrium is one: a pendulum that stands exactly upright stays there in the exact solution. A computed motion would be the growth of
//! its own roundings. They make it fall after some 37 of its time constants, at a meaningless time. A user who wants it to fall has to push it.

use crate::instant::exerting::reactions::Reactions;
use crate::instant::exerting::unbalanced::moves_for_certain;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::{BodyWrench, body_wrenches};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use std::sync::Arc;

/// ε for each body of a tree: some roundings of the sums along the way to the root.
const ROUNDING: f64 = 1e-15;
/// ε for each body where there are closures, which are met to some roundings themselves.
const ROUNDING_OF_CLOSURES: f64 = 1e-13;

/// Whether the mechanism stays in this state for ever: it does not move, and no force moves it.
pub fn is_at_rest(mechanism: &Mechanism, state: &State) -> bool {
    is_at_rest_counted(mechanism, state, None)
}

/// The same where the closures were counted already.
pub fn is_at_rest_counted(mechanism: &Mechanism, state: &State, counted: Option<Arc<Counted>>) -> bool {
    if mechanism.changes() || mechanism.bodies.is_empty() || state.velocity.iter().any(|&rate| rate != 0.0) {
        return false;
    }
    let bodies = body_states(mechanism, state);
    if mechanism.forces.point_springs.iter().any(|spring| spring.is_undirected(&bodies)) {
        return false;
    }
    !moves_for_certain(mechanism, &bodies) && nothing_accelerates(mechanism, state, &bodies, counted)
}

/// Whether all accelerations are roundings in a state without velocities.
pub(crate) fn nothing_accelerates(
    mechanism: &Mechanism,
    state: &State,
    bodies: &[BodyState],
    counted: Option<Arc<Counted>>,
) -> bool {
    let mut wrenches = vec![BodyWrench::default(); bodies.len()];
    body_wrenches(mechanism, state.time, bodies, &mut wrenches);
    let mut reactions = Reactions::new(mechanism);
    reactions.expect_at(counted);
    reactions.clock(state.time);
    let accelerations = reactions.accelerations(&state.position, &state.velocity, bodies);
    let rounding = if mechanism.has_closures() { ROUNDING_OF_CLOSURES } else { ROUNDING };
    let rounding = rounding * bodies.len() as f64;
    mechanism.bodies.iter().zip(&wrenches).zip(accelerations).all(|((body, wrench), (linear, angular))| {
        if !linear.iter().chain(angular.iter()).all(|number| number.is_finite()) {
            return false;
        }
        if body.mass == 0.0 {
            // The bodies attached to a massless body show its linear acceleration, and without inertia also its angular acceleration.
            return body.inertia.amax() == 0.0 || angular.amax() == 0.0;
        }
        let gyration = (0.5 * body.inertia.sum() / body.mass).sqrt();
        let allowed = rounding * (mechanism.gravity.amax() + wrench.0.amax() / body.mass);
        allowed.is_finite() && linear.amax() <= allowed && gyration * angular.amax() <= allowed
    })
}

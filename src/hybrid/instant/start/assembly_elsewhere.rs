//! Starts that are on their closures but for roundings: these are taken out on the spanning tree with the least work.
//!
//! ```text
//!     |g(q)| <= 1e-12 size,   |J v| <= 1e-12 fastest       size: the furthest place of a body (m), at least 1
//! ```
//!
//! The least motion onto closures is measured in the coordinates of the file's tree. If only roundings are to be moved, any tree will do. On the
//! file's tree a row of loops may take the cube of their number.

use crate::mechanism::description::joint::FreeRotation;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::energy::{Violation, violation};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::structure::other_tree::OtherTree;
use crate::stepping::trees::other_tree::other_tree;
use std::f64::consts::TAU;

/// Gaps and their rates below this part of the size and of the fastest rate are roundings.
const ROUNDED: f64 = 1e-12;

/// Closes a state on another tree if only roundings are to be taken out and there is a better one; returns whether it has. `close` puts a state of a
/// mechanism on its closures and says whether that is possible.
pub(super) fn close_elsewhere(
    mechanism: &Mechanism,
    state: &mut State,
    close: impl FnOnce(&Mechanism, &mut State) -> bool,
) -> bool {
    let bodies = body_states(mechanism, state);
    let Violation { position, velocity } = violation(mechanism, state, &bodies);
    let size = bodies.iter().fold(1.0_f64, |most, body| most.max(body.position.amax()));
    let fastest = state.velocity.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
    if position.is_nan() || velocity.is_nan() || position > ROUNDED * size || velocity > ROUNDED * fastest {
        return false;
    }
    let Some((tree, _)) = other_tree(mechanism, &[], &[Rule::Planar]) else { return false };
    let Ok(mut other) = OtherTree::new(mechanism, &tree, None, state) else { return false };
    let mut own = State::zero(&other.mechanism);
    other.take(mechanism, state, &mut own);
    if !close(&other.mechanism, &mut own) {
        return false;
    }
    let before = state.position.clone();
    other.give(mechanism, &own, state);
    for joint in other.computed().iter().map(|&body| &mechanism.bodies[body].joint) {
        if joint.kind.rotation() == FreeRotation::AboutZ {
            let slot = joint.position_index + joint.kind.translation_axes().len();
            state.position[slot] += TAU * ((before[slot] - state.position[slot]) / TAU).round();
        }
    }
    true
}

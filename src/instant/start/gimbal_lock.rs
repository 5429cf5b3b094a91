//! Starts in gimbal lock, at which links without mass leave a combination of joint rates undetermined.
//!
//! Joint rates q̇ move the bodies with the momenta G q̇, weighted by the roots of masses m and principal moments I, so that the mass matrix is
//! `H = Gᵀ G`:
//!
//! ```text
//!     G q̇ = ( √m v,  √I Rᵀ ω )  of all bodies and rotors     [√kg m/s]
//!     σ = least over largest singular value of G with columns of length one          in lock: σ < 2e-10
//!     q ← q + δ q̇/|q̇|, δ = 2e-8, or q_j + δ of the joint that leaves the lock furthest, where q̇ does not leave it
//! ```
//!
//! At a distance ε from the lock σ is about ε. A step in the lock has no rates that are smooth in time; steps from 1e-9 beside it have, and their motion
//! is the limit of motions from starts nearer and nearer to the lock.
//!
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th edition, section 5.4, for rank by singular values.

use crate::mechanism::description::body_state::WORLD;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::forward_kinematics;
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;

/// σ of a start in lock.
const LOCKED: f64 = 2e-10;
/// How far the start is moved (rad or m).
const MOVE: f64 = 2e-8;
/// Mechanisms with more degrees of freedom are not looked at.
const MOST: usize = 100;

/// Moves a start out of gimbal lock; returns by how much (rad or m), or `None` for a start that is not in lock or cannot be moved.
pub fn leave_gimbal_lock(mechanism: &Mechanism, state: &mut State) -> Option<f64> {
    let massless = mechanism.bodies.iter().any(|body| body.mass == 0.0);
    let count = mechanism.velocity_count;
    if !massless || mechanism.has_closures() || count > MOST || independence(mechanism, state) >= LOCKED {
        return None;
    }
    let fastest = state.velocity.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
    let along = (fastest > 0.0).then(|| state.velocity.iter().map(|rate| MOVE * rate / fastest).collect::<Vec<_>>());
    let alone = (0..count).map(|freedom| {
        let mut moved = vec![0.0; count];
        moved[freedom] = MOVE;
        moved
    });
    let beside = |moved: &Vec<f64>| {
        let mut beside = state.clone();
        beside.displace(mechanism, moved);
        let inside = mechanism
            .nonsmooth
            .limits
            .iter()
            .all(|limit| (limit.lower..=limit.upper).contains(&beside.position[limit.coordinate.position]));
        let independence = if inside { independence(mechanism, &beside) } else { 0.0 };
        (independence, beside)
    };
    let furthest = |moves: &mut dyn Iterator<Item = Vec<f64>>| {
        let all = moves.map(|moved| beside(&moved));
        all.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(independence, _)| *independence >= LOCKED)
    };
    let (_, out) = furthest(&mut along.into_iter()).or_else(|| furthest(&mut alone.into_iter()))?;
    *state = out;
    Some(MOVE)
}

/// σ of a state; one for a mechanism without freedoms.
fn independence(mechanism: &Mechanism, state: &State) -> f64 {
    let count = mechanism.velocity_count;
    let mut bodies = vec![WORLD; mechanism.bodies.len()];
    let rotors: Vec<(usize, f64)> = mechanism.rotors().collect();
    let mut momenta = DMatrix::zeros(6 * mechanism.bodies.len() + rotors.len(), count);
    for (row, (freedom, armature)) in rotors.iter().enumerate() {
        momenta[(6 * mechanism.bodies.len() + row, *freedom)] = armature.sqrt();
    }
    for freedom in 0..count {
        let mut unit = vec![0.0; count];
        unit[freedom] = 1.0;
        forward_kinematics(mechanism, &state.position, &unit, &mut bodies);
        for (number, (body, at)) in mechanism.bodies.iter().zip(&bodies).enumerate() {
            let turning = at.rotation.transpose() * at.angular_velocity;
            for axis in 0..3 {
                momenta[(6 * number + axis, freedom)] = body.mass.sqrt() * at.velocity[axis];
                momenta[(6 * number + 3 + axis, freedom)] = body.inertia[axis].sqrt() * turning[axis];
            }
        }
        let length = momenta.column(freedom).norm();
        if length > 0.0 {
            momenta.column_mut(freedom).unscale_mut(length);
        }
    }
    let values = momenta.singular_values();
    if values.is_empty() { 1.0 } else { values.min() / values.max().max(f64::MIN_POSITIVE) }
}

//! Whether every motion of a mechanism moves some mass.
//!
//! Massless bodies inside a tree and point masses are legitimate, but if the joint-space mass matrix is singular the motion is not determined. The
//! recursion goes from the leaves inwards. Each body has a 6×6 matrix `C`: if it moves with `t = (v, ω)`, the kinetic energy of its subtree is at
//! least `½ |C t|²`, and equal to it if the joints further out give way. `C` is made by QR of the rows
//!
//! ```text
//!     √m v,   √J_k (Rᵀ ω)_k                           of the body itself, and those that its children have handed to it
//! ```
//!
//! with the velocity `v` of the centre of mass and ω in the axes of the world. Each free direction `s` of its joint then takes its own part out, and
//! the rest is handed to the parent:
//!
//! ```text
//!     c = C s,     C ← (1 − c cᵀ/|c|²) C
//! ```
//!
//! If `c = 0`, the joint moves without moving any mass. `CᵀC` is the articulated inertia and `|c|²` are the pivots of the mass matrix; factors keep
//! twice the digits. The joints are put at odd displacements, so that only a singularity of the structure counts, not one of a special position.

use crate::description::body_state::{BodyState, WORLD};
use crate::description::joint::FreeRotation;
use crate::description::mechanism::{Body, Mechanism};
use crate::ground::matrices::cross_matrix;
use crate::motion::kinematics::{forward_kinematics, place};
use crate::motion::state::quaternion_exponential;
use nalgebra::{Matrix6, SMatrix, Vector6};

/// A direction is lost if `|c|` is less than this part of its value with all joints further out locked: far above rounding, far below mechanics.
const DEPENDENT: f64 = 1e-7;

/// A direction that moves less than this part of the mass and inertia counts as massless: some roundings, and below any mechanics.
const NOTHING: f64 = 1e-14;

/// The body whose joint can move without moving any mass, if there is one: of several the outermost.
///
/// Only looked for where a body lacks mass or inertia: otherwise the mass matrix is positive definite.
pub fn undetermined_body(mechanism: &Mechanism) -> Option<usize> {
    let lacks = |body: &Body| body.mass == 0.0 || body.inertia.min() == 0.0;
    if !mechanism.bodies.iter().any(lacks) {
        return None;
    }
    let position = odd_position(mechanism);
    let mut bodies = vec![WORLD; mechanism.bodies.len()];
    forward_kinematics(mechanism, &position, &vec![0.0; mechanism.velocity_count], &mut bodies);
    // Sums of the factors of each body's children, with their joints free and with all locked.
    let mut free = vec![Matrix6::zeros(); bodies.len()];
    let mut locked = free.clone();
    for (index, body) in mechanism.bodies.iter().enumerate().rev() {
        let (state, parent) = (&bodies[index], body.parent.map_or(WORLD, |parent| bodies[parent]));
        let own = factor(body, state);
        let mut moved = joined(&free[index], &own);
        let whole = joined(&locked[index], &own);
        for freedom in 0..body.joint.kind.velocity_count() {
            let mut rates = [0.0; 6];
            rates[freedom] = 1.0;
            let moving = place(&body.joint, &parent, &position[body.joint.position_range()], &[], &rates).body;
            let direction = motion(&moving);
            let pivot = moved * direction;
            let nothing = NOTHING * whole.norm() * direction.norm();
            if pivot.norm() <= nothing.max(DEPENDENT * (whole * direction).norm()) {
                return Some(index);
            }
            let unit = pivot.normalize();
            moved -= unit * (unit.transpose() * moved);
        }
        if let Some(parent) = body.parent {
            // The centre of mass of the body, rigidly joined to its parent, goes with v + ω × r.
            let mut carried = Matrix6::identity();
            let arm = state.position - bodies[parent].position;
            carried.fixed_view_mut::<3, 3>(0, 3).copy_from(&-cross_matrix(&arm));
            free[parent] = joined(&free[parent], &(moved * carried));
            locked[parent] = joined(&locked[parent], &(whole * carried));
        }
    }
    None
}

/// The factor of one body.
fn factor(body: &Body, state: &BodyState) -> Matrix6<f64> {
    let mut rows = Matrix6::zeros();
    for axis in 0..3 {
        rows[(axis, axis)] = body.mass.sqrt();
        let turned = state.rotation.column(axis).transpose() * body.inertia[axis].max(0.0).sqrt();
        rows.fixed_view_mut::<1, 3>(3 + axis, 3).copy_from(&turned);
    }
    rows
}

/// The factor of two together.
fn joined(one: &Matrix6<f64>, other: &Matrix6<f64>) -> Matrix6<f64> {
    let mut rows = SMatrix::<f64, 12, 6>::zeros();
    rows.fixed_rows_mut::<6>(0).copy_from(one);
    rows.fixed_rows_mut::<6>(6).copy_from(other);
    rows.qr().r()
}

/// The velocity of a body's centre of mass, and its angular velocity.
fn motion(body: &BodyState) -> Vector6<f64> {
    let (v, w) = (body.velocity, body.angular_velocity);
    Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
}

/// Displacements without any symmetry.
pub fn odd_position(mechanism: &Mechanism) -> Vec<f64> {
    let mut position = Vec::with_capacity(mechanism.position_count);
    // Multiples of the golden ratio never repeat modulo one.
    let mut next = {
        let mut count = 0.0;
        move || {
            count += 1.0;
            0.3 + (count * 0.618_033_988_749_894_9_f64).fract()
        }
    };
    for body in &mechanism.bodies {
        position.extend(body.joint.kind.translation_axes().iter().map(|_| next()));
        match body.joint.kind.rotation() {
            FreeRotation::None => {}
            FreeRotation::AboutZ => position.push(next()),
            FreeRotation::Ball => position.extend(quaternion_exponential(&[next(), next(), next()])),
        }
    }
    position
}

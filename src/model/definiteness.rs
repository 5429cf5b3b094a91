//! Whether every motion of a mechanism moves some mass.
//!
//! Massless bodies inside a tree and point masses are legitimate, but if the joint-space mass matrix `M = Bᵀ B` is
//! singular the motion is not determined. The rows of `B` are `√m v` and `√J_k ω_k` of every body, its columns the
//! joint velocities; Gram–Schmidt finds the first column that depends on those after it. The joints are put at odd
//! displacements, so that only a singularity of the structure counts, not one of a special position.

use super::joint::FreeRotation;
use super::mechanism::Mechanism;
use crate::kinematics::{WORLD, forward_kinematics};
use crate::state::quaternion_exponential;
use nalgebra::DVector;

/// A column that keeps less than this part of its length is dependent: far above rounding, far below mechanics.
const DEPENDENT: f64 = 1e-7;

/// The body whose joint can move without moving any mass, if there is one.
///
/// Only looked for where a body lacks mass or inertia: otherwise `M` is positive definite.
pub fn undetermined_body(mechanism: &Mechanism) -> Option<usize> {
    let lacks = |body: &super::Body| body.mass == 0.0 || body.inertia.min() == 0.0;
    if !mechanism.bodies.iter().any(lacks) {
        return None;
    }
    let position = odd_position(mechanism);
    let mut bodies = vec![WORLD; mechanism.bodies.len()];
    let mut basis: Vec<DVector<f64>> = Vec::new();
    // From the leaves inwards: the first dependent column then belongs to the outermost joint without inertia.
    for (index, body) in mechanism.bodies.iter().enumerate().rev() {
        for column in body.joint.velocity_range() {
            let mut velocity = vec![0.0; mechanism.velocity_count];
            velocity[column] = 1.0;
            forward_kinematics(mechanism, &position, &velocity, &mut bodies);
            let mut row = DVector::zeros(6 * bodies.len());
            for (number, (body, state)) in mechanism.bodies.iter().zip(&bodies).enumerate() {
                let spin = state.rotation.transpose() * state.angular_velocity;
                for k in 0..3 {
                    row[6 * number + k] = body.mass.sqrt() * state.velocity[k];
                    row[6 * number + 3 + k] = body.inertia[k].max(0.0).sqrt() * spin[k];
                }
            }
            let length = row.norm();
            // Twice, because once loses digits when the column is nearly dependent.
            for _ in 0..2 {
                for unit in &basis {
                    row -= unit * unit.dot(&row);
                }
            }
            let rest = row.norm();
            if rest <= DEPENDENT * length {
                return Some(index);
            }
            basis.push(row / rest);
        }
    }
    None
}

/// Displacements without any symmetry.
pub(super) fn odd_position(mechanism: &Mechanism) -> Vec<f64> {
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

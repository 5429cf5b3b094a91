//! The efforts along the degrees of freedom that do the work of wrenches on bodies.
//!
//! ```text
//!     Q · q̇ = Σ_bodies F · v + T · ω        for every q̇        Q = Jᵀ (F, T)   [N m or N]
//! ```
//!
//! The recursion goes from the tips to the root: the wrench on a subtree about the anchor a of its first joint has the power `F·u + T_a·w` of that
//! joint's rates (u translation, w rotation), and goes on to the parent. If F is the unit normal of a contact and T its arm's torque, Q is the
//! gradient of the gap.

use crate::description::body_state::BodyState;
use crate::description::joint::FreeRotation;
use crate::description::mechanism::Mechanism;
use crate::forces::total::BodyWrench;
use crate::ground::matrices::{column, product, times};
use nalgebra::Vector3;

/// Writes Q for wrenches on the bodies, about their centres of mass; `wrenches` then has the wrenches on the subtrees. Does not allocate.
pub fn efforts_of_wrenches(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    wrenches: &mut [BodyWrench],
    efforts: &mut [f64],
) {
    for (index, body) in mechanism.bodies.iter().enumerate().rev() {
        let (joint, state) = (&body.joint, &bodies[index]);
        let (force, torque) = wrenches[index];
        let efforts = &mut efforts[joint.velocity_range()];
        if force == Vector3::zeros() && torque == Vector3::zeros() {
            efforts.fill(0.0);
            continue;
        }
        let arm = times(&state.rotation, &joint.on_child.translation.vector);
        let about_anchor = torque - arm.cross(&force);
        let on_parent = match body.parent {
            Some(parent) => product(&bodies[parent].rotation, joint.on_parent.rotation.matrix()),
            None => *joint.on_parent.rotation.matrix(),
        };
        let axes = joint.kind.translation_axes();
        for (effort, &axis) in efforts.iter_mut().zip(axes) {
            *effort = column(&on_parent, axis).dot(&force);
        }
        let turns = &mut efforts[axes.len()..];
        let on_child = product(&state.rotation, joint.on_child.rotation.matrix());
        match joint.kind.rotation() {
            FreeRotation::None => {}
            FreeRotation::AboutZ => turns[0] = column(&on_child, 2).dot(&about_anchor),
            FreeRotation::Ball => {
                for (axis, effort) in turns.iter_mut().enumerate() {
                    *effort = column(&on_child, axis).dot(&about_anchor);
                }
            }
        }
        if let Some(parent) = body.parent {
            let arm = state.position - bodies[parent].position;
            wrenches[parent].0 += force;
            wrenches[parent].1 += torque + arm.cross(&force);
        }
    }
}

//! Bodies for which parts of the equations of motion are zero.
//!
//! ```text
//!     sliding:   every joint between the body and the world only slides:   R = R₀,   ω = 0,   J never counts
//!     a point:   J = 0:   no angular momentum about the centre of mass
//!     a sphere:  J = 2σ 1:   J is the same in every orientation
//!     a pivot:   a hinge holds the body to the world:   nothing but its turn about the axis a is left, with aᵀ J a
//!     a tumbler: it floats, and carries nothing:   its centre of mass follows a parabola, its rotation nothing but itself
//! ```
//!
//! All but the last hold in every state, whatever the forces. Spheres and pivots, too, are made use of only under gravity alone: where the
//! unit of mass is the same in every step, an inertia that never changes rounds to one side (`lobatto::stages::start`).

use crate::description::joint::{FreeRotation, JointKind};
use crate::description::mechanism::{Body, Mechanism};
use nalgebra::Vector3;

/// For each body whether it never turns.
pub fn sliding_bodies(mechanism: &Mechanism) -> Vec<bool> {
    let mut sliding: Vec<bool> = Vec::with_capacity(mechanism.bodies.len());
    for body in &mechanism.bodies {
        let parent_slides = body.parent.is_none_or(|parent| sliding[parent]);
        sliding.push(parent_slides && body.joint.kind.rotation() == FreeRotation::None);
    }
    sliding
}

/// Principal moments count as equal if they differ by no more than this part of them: rounding.
const EQUAL: f64 = 1e-15;

/// For each body whether its inertia is the same about all axes, which counts where gravity alone acts on a tree.
pub fn spherical_bodies(mechanism: &Mechanism) -> Vec<bool> {
    let spherical =
        |inertia: &Vector3<f64>| inertia.max() > 0.0 && inertia.max() - inertia.min() <= EQUAL * inertia.max();
    mechanism.bodies.iter().map(|body| mechanism.is_plain_tree() && spherical(&body.inertia)).collect()
}

/// For each body whether its mass is at a point, or zero.
pub fn point_bodies(mechanism: &Mechanism) -> Vec<bool> {
    mechanism.bodies.iter().map(|body| body.inertia == Vector3::zeros()).collect()
}

/// For each body whether a hinge holds it to the world, which counts where gravity alone acts on a tree.
pub fn pivoted_bodies(mechanism: &Mechanism) -> Vec<bool> {
    let plain = mechanism.is_plain_tree();
    let held = |body: &Body| body.parent.is_none() && body.joint.kind == JointKind::Revolute;
    mechanism.bodies.iter().map(|body| plain && held(body)).collect()
}

/// Whether a mechanism is a tumbler: one body, with moments about all axes, that floats freely under gravity alone.
pub fn tumbles(mechanism: &Mechanism) -> bool {
    let [body] = &mechanism.bodies[..] else { return false };
    mechanism.is_plain_tree() && body.joint.kind == JointKind::Floating && body.inertia.min() > 0.0
}

/// For each body whether it is [one that tumbles](tumbles).
pub fn tumbling_bodies(mechanism: &Mechanism) -> Vec<bool> {
    vec![tumbles(mechanism); mechanism.bodies.len()]
}

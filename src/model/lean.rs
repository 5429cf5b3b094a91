//! Bodies of which a part of the equations of motion vanishes.
//!
//! ```text
//!     sliding:   every joint between the body and the world only slides:   R = R₀,   ω = 0,   J never counts
//!     a point:   J = 0:   no angular momentum about the centre of mass
//! ```
//!
//! Both hold in every state, whatever the forces.

use super::joint::FreeRotation;
use super::mechanism::Mechanism;
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

/// For each body whether its mass is at a point, or nowhere.
pub fn point_bodies(mechanism: &Mechanism) -> Vec<bool> {
    mechanism.bodies.iter().map(|body| body.inertia == Vector3::zeros()).collect()
}

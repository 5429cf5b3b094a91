//! Parts of mechanisms that the equations of derivatives do not know: runs with them have no derivatives.

use crate::derivatives::forward::failure::SensitivityError;
use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::joint::FreeRotation;
use crate::mechanism::description::mechanism::Mechanism;
use nalgebra::Vector3;

/// Refuses a mechanism with such parts.
///
/// # Errors
/// [`SensitivityError::Unsupported`] with the part and what to do.
pub(super) fn refuse(mechanism: &Mechanism) -> Result<(), SensitivityError> {
    let refuse = |part, advice| Err(SensitivityError::Unsupported { part, advice });
    const INSTEAD: &str = "leave them out, or compare runs with other numbers";
    let forces = &mechanism.forces;
    if !(forces.link_loads.is_empty() && forces.drags.is_empty() && forces.joint_courses.is_empty()) {
        return refuse("drag and loads over time", INSTEAD);
    }
    if !forces.gravity_compensations.is_empty() {
        return refuse("motors that hold weights", INSTEAD);
    }
    if mechanism.moves_joints() {
        return refuse("joints that are moved in time", INSTEAD);
    }
    let colliders = &mechanism.nonsmooth.colliders;
    if colliders.iter().any(|collider| collider.surface_velocity != Vector3::zeros()) {
        return refuse("surfaces that move over what carries them", INSTEAD);
    }
    if colliders.iter().any(|collider| matches!(collider.shape, Shape::Ellipsoid { .. } | Shape::Hollow { .. })) {
        return refuse("ellipsoids and ropes", INSTEAD);
    }
    if mechanism.nonsmooth.pairs.runs().iter().any(|run| !run.first.moments.are_zero()) {
        return refuse("rolling and spinning friction", INSTEAD);
    }
    let balls = |freedom: usize| {
        let body = mechanism.body_of_freedom(freedom).map(|body| &mechanism.bodies[body].joint);
        body.is_some_and(|joint| {
            joint.kind.rotation() == FreeRotation::Ball
                && freedom >= joint.velocity_index + joint.kind.translation_axes().len()
        })
    };
    if mechanism.forces.joint_dampers.iter().any(|damper| balls(damper.freedom)) {
        return refuse("dampers in ball joints", "leave damping out with --without damping");
    }
    Ok(())
}

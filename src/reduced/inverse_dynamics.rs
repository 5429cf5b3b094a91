//! The wrench each joint carries: Newton and Euler for every subtree.
//!
//! ```text
//!     f = Σ m (ẍ − g) − F                                          [N]    over the bodies of the subtree
//!     n = Σ R J Rᵀ ω̇ + ω × R J Rᵀ ω − N + (x − a) × (m (ẍ − g) − F)  [N m]  about the anchor a of its joint
//!
//!     ω̇ = ω̇_p + R F_c.R ẇ + ω_p × R F_c.R w
//!     ẍ = ẍ_p + ω̇_p × r + ω_p × (ω_p × r) + 2 ω_p × u + u̇ − ω̇ × c − ω × (ω × c),   r = a − x_p,   c = a − x
//! ```
//!
//! with the wrench (F, N) of springs and loads on the body, the joint's sliding velocity u = R_p F_p.R ṫ [m/s] and turning rate w [rad/s], all in the axes of the world.
//! The wrench is the whole of what the parent exerts on the child: along a free direction it is the effort of dampers,
//! springs and loads in the joint, across it the force of constraint.
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, section 5.3.

use crate::closures::BodyAcceleration;
use crate::forces::total::{BodyWrench, body_wrenches};
use crate::kinematics::{WORLD, forward_kinematics, joint_rates};
use crate::model::Mechanism;
use crate::state::BodyState;
use nalgebra::Vector3;

/// What a parent exerts on its child through their joint, in the axes of the world, at the joint's anchor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// The anchor: the origin of the joint frame on the child, in the world (m).
    pub anchor: Vector3<f64>,
    /// Force (N).
    pub force: Vector3<f64>,
    /// Torque about the anchor [N m].
    pub torque: Vector3<f64>,
}

/// The accelerations of all bodies for those of the joints, written into `accelerations`.
pub fn body_accelerations(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    velocity: &[f64],
    acceleration: &[f64],
    accelerations: &mut [BodyAcceleration],
) {
    for (index, body) in mechanism.bodies.iter().enumerate() {
        let joint = &body.joint;
        let state = &bodies[index];
        let (parent, (parent_linear, parent_angular)) =
            body.parent.map_or((WORLD, Default::default()), |parent| (bodies[parent], accelerations[parent]));
        let frame_on_parent = parent.rotation * joint.on_parent.rotation.matrix();
        let frame_on_child = state.rotation * joint.on_child.rotation.matrix();
        let (slide, turn) = joint_rates(joint, &velocity[joint.velocity_range()]);
        let (slide_rate, turn_rate) = joint_rates(joint, &acceleration[joint.velocity_range()]);
        let arm_on_child = state.rotation * joint.on_child.translation.vector;
        let arm_on_parent = state.position + arm_on_child - parent.position;
        let angular =
            parent_angular + frame_on_child * turn_rate + parent.angular_velocity.cross(&(frame_on_child * turn));
        let linear = parent_linear
            + parent_angular.cross(&arm_on_parent)
            + parent.angular_velocity.cross(&parent.angular_velocity.cross(&arm_on_parent))
            + 2.0 * parent.angular_velocity.cross(&(frame_on_parent * slide))
            + frame_on_parent * slide_rate
            - angular.cross(&arm_on_child)
            - state.angular_velocity.cross(&state.angular_velocity.cross(&arm_on_child));
        accelerations[index] = (linear, angular);
    }
}

/// The reactions in all joints, one for each body, for joint accelerations that follow from the state.
pub fn joint_reactions(
    mechanism: &Mechanism,
    position: &[f64],
    velocity: &[f64],
    acceleration: &[f64],
) -> Vec<Reaction> {
    let mut bodies = vec![WORLD; mechanism.bodies.len()];
    forward_kinematics(mechanism, position, velocity, &mut bodies);
    let mut applied = vec![BodyWrench::default(); bodies.len()];
    body_wrenches(mechanism, &bodies, &mut applied);
    let mut accelerations = vec![Default::default(); bodies.len()];
    body_accelerations(mechanism, &bodies, velocity, acceleration, &mut accelerations);
    reactions_under(mechanism, &bodies, &accelerations, &applied)
}

/// The reactions in all joints for the motion of the bodies and the wrenches on them.
pub fn reactions_under(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    accelerations: &[BodyAcceleration],
    applied: &[BodyWrench],
) -> Vec<Reaction> {
    let mut reactions = vec![Reaction::default(); bodies.len()];
    for (index, body) in mechanism.bodies.iter().enumerate() {
        let state = &bodies[index];
        let (linear, angular) = accelerations[index];
        let arm_on_child = state.rotation * body.joint.on_child.translation.vector;
        let anchor = state.position + arm_on_child;
        let in_body = |vector: Vector3<f64>| state.rotation.transpose() * vector;
        let spin = state.rotation * body.inertia.component_mul(&in_body(state.angular_velocity));
        let spin_rate = state.rotation * body.inertia.component_mul(&in_body(angular));
        let (push, twist) = applied[index];
        let force = body.mass * (linear - mechanism.gravity) - push;
        reactions[index] = Reaction {
            anchor,
            force,
            torque: spin_rate + state.angular_velocity.cross(&spin) - twist - arm_on_child.cross(&force),
        };
    }
    // A joint carries what its own body needs and what the joints of the body's children carry.
    for (index, body) in mechanism.bodies.iter().enumerate().rev() {
        if let Some(parent) = body.parent {
            let Reaction { anchor, force, torque } = reactions[index];
            let carrier = &mut reactions[parent];
            carrier.force += force;
            carrier.torque += torque + (anchor - carrier.anchor).cross(&force);
        }
    }
    reactions
}

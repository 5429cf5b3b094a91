//! The wrench each joint carries: Newton and Euler for every subtree.
//!
//! ```text
//!     f = Σ m (ẍ − g) − F                                          [N]    over the bodies of the subtree
//!     n = Σ R J Rᵀ ω̇ + ω × R J Rᵀ ω − N + (x − a) × (m (ẍ − g) − F)  [N m]  about the anchor a of its joint
//! ```
//!
//! with the accelerations of [`catena_mechanism::motion::kinematics`] and the wrench (F, N) of springs and loads on the body, all in the axes of the
//! world.
//! The wrench is the whole of what the parent exerts on the child: along a free direction it is the effort of dampers,
//! springs and loads in the joint, across it the force of constraint.
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, section 5.3.

use catena_mechanism::description::body_state::{BodyState, WORLD};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::{BodyWrench, body_wrenches};
use catena_mechanism::ground::matrices::{cross, times, transpose_times};
use catena_mechanism::motion::kinematics::{BodyAcceleration, body_accelerations, forward_kinematics};
use nalgebra::Vector3;

/// The wrench that a parent exerts on its child through their joint, in the axes of the world, at the joint's anchor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// The anchor: the origin of the joint frame on the child, in the world (m).
    pub anchor: Vector3<f64>,
    /// Force (N).
    pub force: Vector3<f64>,
    /// Torque about the anchor [N m].
    pub torque: Vector3<f64>,
}

/// The reactions in all joints at the time zero, one for each body, for joint accelerations that follow from the state.
pub fn joint_reactions(
    mechanism: &Mechanism,
    position: &[f64],
    velocity: &[f64],
    acceleration: &[f64],
) -> Vec<Reaction> {
    let mut bodies = vec![WORLD; mechanism.bodies.len()];
    forward_kinematics(mechanism, position, velocity, &mut bodies);
    let mut applied = vec![BodyWrench::default(); bodies.len()];
    body_wrenches(mechanism, 0.0, &bodies, &mut applied);
    let mut accelerations = vec![Default::default(); bodies.len()];
    body_accelerations(mechanism, &bodies, velocity, acceleration, &mut accelerations);
    let mut reactions = vec![Reaction::default(); bodies.len()];
    reactions_under(mechanism, &bodies, &accelerations, &applied, &mut reactions);
    reactions
}

/// The reactions in all joints for the motion of the bodies and the wrenches on them, written into `reactions` (one entry a
/// body). Does not allocate.
pub fn reactions_under(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    accelerations: &[BodyAcceleration],
    applied: &[BodyWrench],
    reactions: &mut [Reaction],
) {
    for (index, body) in mechanism.bodies.iter().enumerate() {
        let state = &bodies[index];
        let (linear, angular) = accelerations[index];
        let arm_on_child = times(&state.rotation, &body.joint.on_child.translation.vector);
        let anchor = state.position + arm_on_child;
        let of_inertia = |turning: &Vector3<f64>| {
            times(&state.rotation, &body.inertia.component_mul(&transpose_times(&state.rotation, turning)))
        };
        let (spin, spin_rate) = (of_inertia(&state.angular_velocity), of_inertia(&angular));
        let (push, twist) = applied[index];
        let force = body.mass * (linear - mechanism.gravity) - push;
        reactions[index] = Reaction {
            anchor,
            force,
            torque: spin_rate + cross(&state.angular_velocity, &spin) - twist - cross(&arm_on_child, &force),
        };
    }
    // A joint carries what its own body needs and what the joints of the body's children carry.
    for (index, body) in mechanism.bodies.iter().enumerate().rev() {
        if let Some(parent) = body.parent {
            let Reaction { anchor, force, torque } = reactions[index];
            let carrier = &mut reactions[parent];
            carrier.force += force;
            carrier.torque += torque + cross(&(anchor - carrier.anchor), &force);
        }
    }
}

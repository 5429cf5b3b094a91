//! The accelerations of a joint's coordinates between two bodies whose motion is known: the inverse of
//! [`crate::motion::kinematics::body_accelerations`].
//!
//! Let `r = a − x_p` and `c = a − x` be the arms from both centres of mass to the anchor, `u` and `w` the joint's rates, and `A = R_p F_p.R`,
//! `B = R F_c.R`:
//!
//! ```text
//!     ẇ = Bᵀ (ω̇ − ω̇_p − ω_p × B w)
//!     u̇ = Aᵀ (ẍ + ω̇ × c + ω × (ω × c) − ẍ_p − ω̇_p × r − ω_p × (ω_p × r) − 2 ω_p × A u)
//! ```
//!
//! Accelerations against the joint's constraints are ignored.

use crate::description::body_state::BodyState;
use crate::description::joint::{FreeRotation, Joint};
use crate::ground::matrices::{cross, product, times};
use crate::motion::kinematics::{BodyAcceleration, joint_rates};

/// Writes the accelerations of a joint between a parent and a child (`velocity_count` numbers) for its rates. Does not allocate.
pub fn joint_accelerations(
    joint: &Joint,
    [parent, child]: [&BodyState; 2],
    [(parent_linear, parent_angular), (linear, angular)]: [BodyAcceleration; 2],
    rates: &[f64],
    accelerations: &mut [f64],
) {
    let on_child = product(&child.rotation, joint.on_child.rotation.matrix());
    let (translation, rotation) = joint_rates(joint, rates);
    let axes = joint.kind.translation_axes();
    if !axes.is_empty() {
        let on_parent = product(&parent.rotation, joint.on_parent.rotation.matrix());
        let arm = times(&child.rotation, &joint.on_child.translation.vector);
        let from_parent = child.position + arm - parent.position;
        let carried = parent_linear
            + cross(&parent_angular, &from_parent)
            + cross(&parent.angular_velocity, &cross(&parent.angular_velocity, &from_parent))
            + 2.0 * cross(&parent.angular_velocity, &times(&on_parent, &translation));
        let anchor =
            linear + cross(&angular, &arm) + cross(&child.angular_velocity, &cross(&child.angular_velocity, &arm));
        let along = on_parent.tr_mul(&(anchor - carried));
        for (acceleration, &axis) in accelerations.iter_mut().zip(axes) {
            *acceleration = along[axis];
        }
    }
    let turning = angular - parent_angular - cross(&parent.angular_velocity, &times(&on_child, &rotation));
    let turning = on_child.tr_mul(&turning);
    let turns = &mut accelerations[axes.len()..];
    match joint.kind.rotation() {
        FreeRotation::None => {}
        FreeRotation::AboutZ => turns[0] = turning.z,
        FreeRotation::Ball => turns.copy_from_slice(turning.as_slice()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::joint::{JointKind, Pose};
    use crate::description::mechanism::{Body, Mechanism};
    use crate::motion::kinematics::{body_accelerations, body_states};
    use crate::motion::state::State;
    use nalgebra::{Rotation3, Translation3, Vector3};

    #[test]
    fn accelerations_of_a_joint_come_back_from_the_bodies_that_it_moves() {
        let frame = |x: f64| {
            Pose::from_parts(Translation3::new(x, 0.3, -0.2), Rotation3::from_euler_angles(0.4 + x, -0.7, 1.1 * x))
        };
        let body = |parent, kind| Body {
            name: format!("{kind:?}"),
            parent,
            mass: 1.0,
            inertia: Vector3::repeat(1.0),
            joint: Joint::new("joint", kind, frame(0.5), frame(-0.4)),
        };
        use JointKind::{Floating, Planar, Prismatic, Revolute, Spherical};
        for kind in [Floating, Planar, Prismatic, Revolute, Spherical] {
            let bodies = vec![body(None, Floating), body(Some(0), kind)];
            let mechanism = Mechanism::new("two", Vector3::zeros(), bodies).unwrap();
            let mut state = State::zero(&mechanism);
            let numbers = |phase: f64| -> Vec<f64> {
                (0..mechanism.velocity_count).map(|entry| (1.3 * entry as f64 + phase).sin()).collect()
            };
            state.displace(&mechanism, &numbers(0.3));
            state.velocity = numbers(1.1);
            let wanted = numbers(2.2);
            let bodies = body_states(&mechanism, &state);
            let mut motion = vec![BodyAcceleration::default(); 2];
            body_accelerations(&mechanism, &bodies, &state.velocity, &wanted, &mut motion);
            let joint = &mechanism.bodies[1].joint;
            let mut found = vec![0.0; kind.velocity_count()];
            let rates = &state.velocity[joint.velocity_range()];
            joint_accelerations(joint, [&bodies[0], &bodies[1]], [motion[0], motion[1]], rates, &mut found);
            let off = found.iter().zip(&wanted[joint.velocity_range()]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Sums of a dozen terms of some units, rounded.
            assert!(off < 1e-13, "{kind:?}: {found:?}, off by {off:e}");
        }
    }
}

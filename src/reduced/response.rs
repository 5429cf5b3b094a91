//! Joint accelerations of a tree under one set of joint forces after another, at one configuration: H⁻¹ τ.
//!
//! The articulated inertias do not depend on τ. The elimination of the last evaluation of [`crate::articulated_body`] is used again, and only the
//! wrenches go from leaf to root:
//!
//! ```text
//!     y = τ − sᵀ(n, f),    (n, f) ← (n, f) + U y/d       for each free screw s, from a subtree that needs (n, f) = 0
//! ```
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, section 7.3.

use crate::articulated_body::ArticulatedBody;
use catena_mechanism::description::joint::JointKind;
use catena_mechanism::ground::matrices::{cross, dot};
use nalgebra::Vector3;

impl ArticulatedBody {
    /// H⁻¹ τ at the configuration of the last evaluation, whatever its velocities and forces were: accelerations for joint forces τ (N or N m), both
    /// one entry a degree of freedom. Does not allocate.
    pub fn respond(&mut self, joint_force: &[f64], acceleration: &mut [f64]) {
        self.wrenches.fill((Vector3::zeros(), Vector3::zeros()));
        for (index, link) in self.links.iter().enumerate().rev() {
            let (mut torque, mut force) = self.wrenches[index + 1];
            let arm = &self.motion[index + 1].arm;
            let first = link.velocity_index;
            if link.kind == JointKind::Revolute {
                let screw = &mut self.screws[first];
                let unbalanced = joint_force[first] - dot(&screw.axis, &torque);
                screw.free = unbalanced * screw.inverse;
                // The screw of a revolute joint is referred to the parent's anchor.
                torque += cross(arm, &force) + screw.angular * unbalanced;
                force += screw.linear * unbalanced;
            } else {
                let translations = link.kind.translation_axes().len();
                for offset in (0..link.kind.velocity_count()).rev() {
                    let screw = &mut self.screws[first + offset];
                    let along = if offset < translations { &force } else { &torque };
                    let unbalanced = joint_force[first + offset] - dot(&screw.axis, along);
                    screw.free = unbalanced * screw.inverse;
                    torque += screw.angular * unbalanced;
                    force += screw.linear * unbalanced;
                }
                torque += cross(arm, &force);
            }
            let (of_parent, onto) = &mut self.wrenches[link.parent];
            *of_parent += torque;
            *onto += force;
        }
        self.resolve_accelerations(acceleration);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use catena_mechanism::description::joint::{Joint, Pose};
    use catena_mechanism::description::mechanism::{Body, Mechanism};

    /// A floating trunk with a slider, a hinge on it, a ball, and a second branch.
    fn tree() -> Mechanism {
        let body = |name: &str, parent, kind| {
            let rotation = nalgebra::Rotation3::from_euler_angles(0.3, -0.4, 0.9);
            let before = Pose { rotation, translation: Vector3::new(0.1, 0.2, -0.3).into() };
            let joint = Joint::new(name, kind, before, Pose::translation(0.2, -0.1, 0.4));
            Body { name: name.into(), parent, mass: 1.5, inertia: Vector3::new(0.1, 0.2, 0.25), joint }
        };
        let bodies = vec![
            body("trunk", None, JointKind::Floating),
            body("slider", Some(0), JointKind::Prismatic),
            body("hinge", Some(1), JointKind::Revolute),
            body("ball", Some(2), JointKind::Spherical),
            body("branch", Some(0), JointKind::Revolute),
            body("hand", Some(4), JointKind::Revolute),
        ];
        Mechanism::new("tree", Vector3::new(0.0, 0.0, -9.81), bodies).unwrap()
    }

    #[test]
    fn a_response_is_the_difference_of_accelerations_with_and_without_the_forces() {
        let mechanism = tree();
        let mut articulated = ArticulatedBody::new(&mechanism);
        let state = catena_mechanism::motion::state::State::zero(&mechanism);
        let count = mechanism.velocity_count;
        let velocity: Vec<f64> = (0..count).map(|freedom| (1.3 * freedom as f64).sin()).collect();
        let accelerations = |articulated: &mut ArticulatedBody, force: &[f64]| {
            let mut out = vec![0.0; count];
            articulated.accelerations(&state.position, &velocity, Some(force), &mut out);
            out
        };
        let without = accelerations(&mut articulated, &vec![0.0; count]);
        for freedom in 0..count {
            let mut force = vec![0.0; count];
            (force[freedom], force[(freedom + 3) % count]) = (2.0, -0.7);
            let with = accelerations(&mut articulated, &force);
            let mut response = vec![0.0; count];
            articulated.respond(&force, &mut response);
            for (index, response) in response.iter().enumerate() {
                let expected = with[index] - without[index];
                // Accelerations are a hundred at most, so that their difference is rounded to 1e-14.
                assert!((response - expected).abs() < 1e-11, "{freedom}, {index}: {response} for {expected}");
            }
            assert!(response.iter().any(|value| value.abs() > 0.1));
        }
    }
}

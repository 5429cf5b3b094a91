//! The coordinates of a joint between two bodies whose places and velocities are known: the inverse of [`crate::motion::kinematics`].
//!
//! Let `A = R_p F_p.R` be the joint frame on the parent and `B = R F_c.R` on the child, with the origins `a` and `b` in the world:
//!
//! ```text
//!     t = Aᵀ (b − a)        Rj = Aᵀ B        w = Bᵀ (ω − ω_p)        u = Aᵀ (ḃ − v_p − ω_p × (b − x_p))
//! ```
//!
//! Angles come out from −π to π. Displacements against the joint's constraints are ignored.

use crate::description::body_state::BodyState;
use crate::description::joint::{FreeRotation, Joint, wxyz_from_rotation};
use crate::ground::matrices::{cross, product, times};

/// Writes the position (`position_count` numbers) and velocity (`velocity_count` numbers) of a joint between a parent and a child. Does not
/// allocate.
pub fn joint_coordinates(
    joint: &Joint,
    parent: &BodyState,
    child: &BodyState,
    position: &mut [f64],
    velocity: &mut [f64],
) {
    let on_parent = product(&parent.rotation, joint.on_parent.rotation.matrix());
    let on_child = product(&child.rotation, joint.on_child.rotation.matrix());
    let turn = on_parent.tr_mul(&on_child);
    let rates = on_child.tr_mul(&(child.angular_velocity - parent.angular_velocity));
    let axes = joint.kind.translation_axes();
    if !axes.is_empty() {
        let arm = times(&child.rotation, &joint.on_child.translation.vector);
        let origin = parent.position + times(&parent.rotation, &joint.on_parent.translation.vector);
        let place = child.position + arm;
        let speed = child.velocity + cross(&child.angular_velocity, &arm)
            - parent.velocity
            - cross(&parent.angular_velocity, &(place - parent.position));
        let (translation, sliding) = (on_parent.tr_mul(&(place - origin)), on_parent.tr_mul(&speed));
        for (slot, &axis) in axes.iter().enumerate() {
            (position[slot], velocity[slot]) = (translation[axis], sliding[axis]);
        }
    }
    let slot = axes.len();
    match joint.kind.rotation() {
        FreeRotation::None => {}
        FreeRotation::AboutZ => {
            position[slot] = (turn.m21 - turn.m12).atan2(turn.m11 + turn.m22);
            velocity[slot] = rates.z;
        }
        FreeRotation::Ball => {
            position[slot..slot + 4].copy_from_slice(&wxyz_from_rotation(&turn));
            velocity[slot..slot + 3].copy_from_slice(rates.as_slice());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::body_state::WORLD;
    use crate::description::joint::{JointKind, Pose};
    use crate::motion::kinematics::place;
    use nalgebra::{Rotation3, Translation3};

    #[test]
    fn coordinates_of_a_joint_come_back_from_the_bodies_that_it_places() {
        let frame = |x: f64| {
            Pose::from_parts(Translation3::new(x, 0.3, -0.2), Rotation3::from_euler_angles(0.4 + x, -0.7, 1.1 * x))
        };
        let turn = wxyz_from_rotation(Rotation3::from_euler_angles(0.2, 0.9, -0.5).matrix());
        for (kind, position) in [
            (JointKind::Revolute, vec![2.9]),
            (JointKind::Prismatic, vec![-0.8]),
            (JointKind::Planar, vec![0.4, -1.3, -2.0]),
            (JointKind::Spherical, turn.to_vec()),
            (JointKind::Floating, [&[0.5, 0.1, -0.9][..], &turn].concat()),
        ] {
            let velocity: Vec<f64> = (0..kind.velocity_count()).map(|entry| 0.7 - 0.4 * entry as f64).collect();
            let base = Joint::new("base", JointKind::Floating, frame(0.1), frame(0.9));
            let at = [&[0.3, -0.6, 0.2][..], &turn].concat();
            let parent = place(&base, &WORLD, &at, &[], &[0.3, -0.2, 0.5, 0.8, -1.1, 0.6]).body;
            let joint = Joint::new("joint", kind, frame(0.5), frame(-0.4));
            let child = place(&joint, &parent, &position, &[], &velocity).body;
            let (mut q, mut w) = (vec![0.0; position.len()], vec![0.0; velocity.len()]);
            joint_coordinates(&joint, &parent, &child, &mut q, &mut w);
            // A few products of rotations, rounded.
            let off = q.iter().zip(&position).chain(w.iter().zip(&velocity)).map(|(a, b)| (a - b).abs());
            let off = off.fold(0.0, f64::max);
            assert!(off < 3e-15, "{kind:?}: {q:?} {w:?}, off by {off:e}");
        }
    }
}

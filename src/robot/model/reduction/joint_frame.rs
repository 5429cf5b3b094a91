//! A joint of the mechanism from a URDF joint: its kind, and the place of its frame.
//!
//! A mechanism's joint moves along or about `z` of its frame. `A` is the rotation whose third column is the URDF axis `n`, `O` the URDF joint frame
//! on the parent link's body, and `L` the child link frame in its body:
//!
//! ```text
//!     F_parent = O A        F_child = L A        so that at zero displacement O = (the child's link frame), as in URDF
//! ```
//!
//! Spherical joints have no axis (`A = 1`); for floating joints `F_child = 1`, so that the joint's coordinates are
//! the pose of the body's principal frame in the joint frame.

use crate::mechanism::description::joint::{JointKind, Pose};
use crate::scene::UrdfJointKind;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// The kind of joint that a URDF type is; `None` for fixed.
pub fn joint_kind(kind: UrdfJointKind) -> Option<JointKind> {
    match kind {
        UrdfJointKind::Revolute | UrdfJointKind::Continuous => Some(JointKind::Revolute),
        UrdfJointKind::Prismatic => Some(JointKind::Prismatic),
        UrdfJointKind::Planar => Some(JointKind::Planar),
        UrdfJointKind::Spherical => Some(JointKind::Spherical),
        UrdfJointKind::Floating => Some(JointKind::Floating),
        UrdfJointKind::Fixed => None,
    }
}

/// The rotation whose columns are the in-plane axes `x`, `y` and the unit axis `n`.
///
/// `x` is the next axis of the cycle x → y → z → x after the largest entry of `n`, made orthogonal to `n`:
/// for `n = z` the plane is (x, y), for `n = x` (y, z), for `n = y` (z, x).
pub fn axis_rotation(axis: &Vector3<f64>) -> Rotation3<f64> {
    let next = (axis.iamax() + 1) % 3;
    let x = (Vector3::ith(next, 1.0) - axis * axis[next]).normalize();
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, axis.cross(&x), *axis]))
}

/// The joint frame on the parent and on the child, from the URDF's joint frame on the parent and the child's link frame.
pub fn joint_frames(kind: JointKind, axis: &Vector3<f64>, on_parent: &Pose, child_link: &Pose) -> (Pose, Pose) {
    match kind {
        JointKind::Revolute | JointKind::Prismatic | JointKind::Planar => {
            let turn = axis_rotation(axis);
            (on_parent * turn, child_link * turn)
        }
        JointKind::Spherical => (*on_parent, *child_link),
        JointKind::Floating => (*on_parent, Pose::identity()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_of_the_coordinate_axes_are_the_cyclic_ones() {
        for k in 0..3 {
            let turn = axis_rotation(&Vector3::ith(k, 1.0)).into_inner();
            assert_eq!(turn.column(0), Vector3::ith((k + 1) % 3, 1.0));
            assert_eq!(turn.column(1), Vector3::ith((k + 2) % 3, 1.0));
            assert_eq!(turn.column(2), Vector3::ith(k, 1.0));
        }
    }

    #[test]
    fn every_axis_gives_a_rotation_with_it_as_z() {
        for (x, y, z) in [(1.0, 2.0, 3.0), (-1.0, 0.2, 0.1), (0.0, -1.0, 0.0), (1.0, 1.0, 1.0), (-1.0, -1.0, 1e-9)] {
            let axis = Vector3::new(x, y, z).normalize();
            let turn = axis_rotation(&axis).into_inner();
            assert!((turn.transpose() * turn - Matrix3::identity()).amax() < 1e-15 * 3.0);
            assert!((turn.determinant() - 1.0).abs() < 1e-15 * 3.0);
            assert_eq!(turn.column(2), axis);
        }
    }
}

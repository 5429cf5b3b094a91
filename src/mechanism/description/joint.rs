//! A joint: which relative motions of two bodies stay free.
//!
//! The joint frame `F` is fixed in both bodies; at zero displacement the two copies coincide. The joint has the translation `t` (in `F` on the
//! parent) and the rotation `Rj`:
//!
//! ```text
//!     R_child  = R_parent · F_p.R · Rj · F_c.Rᵀ
//!     anchor   = x_parent + R_parent (F_p.t + F_p.R t)          [m]   the origin of F on the child, in the world
//!     x_child  = anchor − R_child F_c.t
//! ```
//!
//! Every kind is a choice of free translation axes followed by a choice of free rotations, and the axis of a
//! revolute, prismatic or planar joint is always `z` of the joint frame:
//!
//! | kind      | free translations | free rotations | positions                  | velocities            |
//! |-----------|-------------------|----------------|----------------------------|-----------------------|
//! | revolute  | none              | about z        | angle                      | rate                  |
//! | prismatic | z                 | none           | length                     | rate                  |
//! | planar    | x, y              | about z        | x, y, angle                | rates                 |
//! | spherical | none              | all            | quaternion w, x, y, z      | ω of the child, in F_c |
//! | floating  | x, y, z           | all            | x, y, z, quaternion        | rates, ω of the child in F_c |

use nalgebra::{IsometryMatrix3, Matrix3, Quaternion, UnitQuaternion, Vector3};

/// A rigid placement: rotation matrix and translation (m).
pub type Pose = IsometryMatrix3<f64>;

/// Which relative motions a joint leaves free; see the table of the module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// One rotation about z of the joint frame (URDF `revolute` and `continuous`).
    Revolute,
    /// One translation along z of the joint frame.
    Prismatic,
    /// Two translations along x and y, and the rotation about z.
    Planar,
    /// Every rotation about the anchor.
    Spherical,
    /// Every relative motion.
    Floating,
}

/// The free rotations of a joint kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreeRotation {
    /// The relative rotation is fixed.
    None,
    /// One angle about z of the joint frame.
    AboutZ,
    /// Any rotation, stored as a unit quaternion.
    Ball,
}

impl JointKind {
    /// The joint-frame axes (0 = x, 1 = y, 2 = z) along which the joint may translate.
    #[inline]
    pub fn translation_axes(self) -> &'static [usize] {
        match self {
            JointKind::Revolute | JointKind::Spherical => &[],
            JointKind::Prismatic => &[2],
            JointKind::Planar => &[0, 1],
            JointKind::Floating => &[0, 1, 2],
        }
    }

    /// The joint-frame axes along which it may not.
    #[inline]
    pub fn fixed_axes(self) -> &'static [usize] {
        match self {
            JointKind::Revolute | JointKind::Spherical => &[0, 1, 2],
            JointKind::Prismatic => &[0, 1],
            JointKind::Planar => &[2],
            JointKind::Floating => &[],
        }
    }

    /// The axes of the child's joint frame about which the joint may turn.
    #[inline]
    pub fn rotation_axes(self) -> &'static [usize] {
        match self.rotation() {
            FreeRotation::None => &[],
            FreeRotation::AboutZ => &[2],
            FreeRotation::Ball => &[0, 1, 2],
        }
    }

    /// The free rotations.
    #[inline]
    pub fn rotation(self) -> FreeRotation {
        match self {
            JointKind::Prismatic => FreeRotation::None,
            JointKind::Revolute | JointKind::Planar => FreeRotation::AboutZ,
            JointKind::Spherical | JointKind::Floating => FreeRotation::Ball,
        }
    }

    /// Number of entries in the position vector (a ball rotation has four).
    #[inline]
    pub fn position_count(self) -> usize {
        self.translation_axes().len()
            + match self.rotation() {
                FreeRotation::None => 0,
                FreeRotation::AboutZ => 1,
                FreeRotation::Ball => 4,
            }
    }

    /// Number of degrees of freedom, which is the number of entries in the velocity vector.
    #[inline]
    pub fn velocity_count(self) -> usize {
        self.translation_axes().len() + self.rotation_axes().len()
    }

    /// The unit of a degree of freedom, counted from the first: translations come before rotations.
    pub fn unit(self, freedom: usize) -> &'static str {
        if freedom < self.translation_axes().len() { "m" } else { "rad" }
    }

    /// The URDF-style name, for tables and messages.
    pub fn name(self) -> &'static str {
        match self {
            JointKind::Revolute => "revolute",
            JointKind::Prismatic => "prismatic",
            JointKind::Planar => "planar",
            JointKind::Spherical => "spherical",
            JointKind::Floating => "floating",
        }
    }

    /// The positions at zero displacement.
    pub fn zero_position(self) -> Vec<f64> {
        let mut position = vec![0.0; self.position_count()];
        if self.rotation() == FreeRotation::Ball {
            position[self.translation_axes().len()] = 1.0;
        }
        position
    }
}

/// The joint that connects a body to its parent.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name from the input.
    pub name: String,
    /// Which motions are free.
    pub kind: JointKind,
    /// The joint frame in the parent's body frame, or in the world for a root.
    pub on_parent: Pose,
    /// The joint frame in the child's body frame.
    pub on_child: Pose,
    /// First entry of this joint in the position vector.
    pub position_index: usize,
    /// First entry of this joint in the velocity vector.
    pub velocity_index: usize,
    /// Inertia of a rotor that is geared to the joint, about the coordinate of the joint [kg m² or kg]: it adds `½ armature q̇²` to the kinetic
    /// energy. Zero but for joints with one degree of freedom.
    pub armature: f64,
}

impl Joint {
    /// A joint whose place in the state vectors [`crate::description::mechanism::Mechanism::new`] will fill in.
    pub fn new(name: &str, kind: JointKind, on_parent: Pose, on_child: Pose) -> Self {
        Joint { name: name.to_string(), kind, on_parent, on_child, position_index: 0, velocity_index: 0, armature: 0.0 }
    }

    /// The entries of this joint in the position vector.
    #[inline]
    pub fn position_range(&self) -> std::ops::Range<usize> {
        self.position_index..self.position_index + self.kind.position_count()
    }

    /// The entries of this joint in the velocity vector.
    #[inline]
    pub fn velocity_range(&self) -> std::ops::Range<usize> {
        self.velocity_index..self.velocity_index + self.kind.velocity_count()
    }

    /// Translation `t` (m) and rotation `Rj` of the joint for its own positions (`position_count` numbers) and their rounding errors (as many
    /// numbers, or an empty slice): without these, the angle of a joint that has turned a thousand times is known to 1e-12 rad.
    #[inline(always)]
    pub fn displacement(&self, position: &[f64], rest: &[f64]) -> (Vector3<f64>, Matrix3<f64>) {
        let axes = self.kind.translation_axes();
        let mut translation = Vector3::zeros();
        for (&axis, &value) in axes.iter().zip(position) {
            translation[axis] = value;
        }
        let rotation = match self.kind.rotation() {
            FreeRotation::None => Matrix3::identity(),
            FreeRotation::AboutZ => {
                let (sine, cosine) = sine_cosine(position[axes.len()], rest.get(axes.len()).copied().unwrap_or(0.0));
                Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0)
            }
            FreeRotation::Ball => rotation_from_wxyz(&position[axes.len()..]),
        };
        (translation, rotation)
    }
}

/// Sine and cosine of an angle and its rounding error (rad).
#[inline]
pub fn sine_cosine(angle: f64, rest: f64) -> (f64, f64) {
    let (sine, cosine) = angle.sin_cos();
    (sine + rest * cosine, cosine - rest * sine)
}

/// The rotation matrix of a quaternion given as (w, x, y, z); the quaternion is normalised first.
pub fn rotation_from_wxyz(q: &[f64]) -> Matrix3<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3])).to_rotation_matrix().into_inner()
}

/// The unit quaternion (w, x, y, z) with w ≥ 0 of a rotation matrix.
pub fn wxyz_from_rotation(rotation: &Matrix3<f64>) -> [f64; 4] {
    let quaternion = UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(*rotation));
    let sign = if quaternion.w < 0.0 { -1.0 } else { 1.0 };
    [sign * quaternion.w, sign * quaternion.i, sign * quaternion.j, sign * quaternion.k]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn along_each_axis_a_joint_slides_or_is_fixed() {
        for kind in
            [JointKind::Revolute, JointKind::Prismatic, JointKind::Planar, JointKind::Spherical, JointKind::Floating]
        {
            for axis in 0..3 {
                assert!(
                    kind.translation_axes().contains(&axis) != kind.fixed_axes().contains(&axis),
                    "{kind:?}, {axis}"
                );
            }
        }
    }
}

//! Constants of a body for the articulated-body algorithm, and how a joint's coordinates become a motion.

use catena_mechanism::description::joint::{FreeRotation, JointKind, rotation_from_wxyz};
use catena_mechanism::description::mechanism::Body;
use catena_mechanism::ground::matrices::{Symmetric, column, from_columns};
use nalgebra::{Matrix3, Vector3};

/// The constants of a body, in its joint frame.
#[derive(Clone, Debug)]
pub struct Link {
    pub kind: JointKind,
    /// Entry of the parent in the workspace, where the world is entry 0.
    pub parent: usize,
    /// Whether the next body is a child.
    pub next_is_child: bool,
    /// Whether there are other children.
    pub branches: bool,
    pub position_index: usize,
    pub velocity_index: usize,
    /// The joint frame on the parent, seen from the parent's own joint frame.
    pub mount: Matrix3<f64>,
    /// The vector from the parent's anchor to the origin of the joint frame on the parent, in the parent's joint frame [m].
    pub arm: Vector3<f64>,
    pub mass: f64,
    /// Mass times the arm from the anchor to the centre of mass [kg m].
    pub moment: Vector3<f64>,
    /// Inertia about the anchor [kg m²].
    pub inertia: Symmetric,
    /// Inertia of the rotor of its joint [kg m² or kg].
    pub armature: f64,
}

impl Link {
    /// The constants of one body; who its children are is filled in afterwards.
    pub fn new(bodies: &[Body], index: usize) -> Self {
        let body = &bodies[index];
        let joint = &body.joint;
        let frame_on_child = joint.on_child.rotation.matrix();
        let (mount, arm) = match body.parent {
            // The place of a root in the world does not matter: gravity is uniform.
            None => (*joint.on_parent.rotation.matrix(), Vector3::zeros()),
            Some(parent) => {
                let anchor = &bodies[parent].joint.on_child;
                let seen = anchor.inverse() * joint.on_parent;
                (*seen.rotation.matrix(), seen.translation.vector)
            }
        };
        let centre = -(frame_on_child.transpose() * joint.on_child.translation.vector);
        let steiner = Matrix3::identity() * centre.norm_squared() - centre * centre.transpose();
        let inertia =
            frame_on_child.transpose() * Matrix3::from_diagonal(&body.inertia) * frame_on_child + steiner * body.mass;
        Link {
            kind: joint.kind,
            parent: body.parent.map_or(0, |parent| parent + 1),
            next_is_child: false,
            branches: false,
            position_index: joint.position_index,
            velocity_index: joint.velocity_index,
            mount,
            arm,
            mass: body.mass,
            moment: centre * body.mass,
            inertia: Symmetric::from_matrix(&inertia),
            armature: joint.armature,
        }
    }
}

/// Joint translation and rotation from the head of a position vector.
#[inline]
pub fn split_position(kind: JointKind, position: &[f64]) -> (Vector3<f64>, Matrix3<f64>) {
    let axes = kind.translation_axes();
    let rotation = match kind.rotation() {
        FreeRotation::None => Matrix3::identity(),
        FreeRotation::AboutZ => rotate_about_z(&Matrix3::identity(), position[axes.len()]),
        FreeRotation::Ball => rotation_from_wxyz(&position[axes.len()..]),
    };
    (split_translation(kind, position), rotation)
}

/// Translation rates and rotation rates from the head of a velocity vector.
#[inline]
pub fn split_velocity(kind: JointKind, velocity: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
    let turn = &velocity[kind.translation_axes().len()..];
    let rotation = match kind.rotation() {
        FreeRotation::None => Vector3::zeros(),
        FreeRotation::AboutZ => Vector3::new(0.0, 0.0, turn[0]),
        FreeRotation::Ball => Vector3::new(turn[0], turn[1], turn[2]),
    };
    (split_translation(kind, velocity), rotation)
}

#[inline]
fn split_translation(kind: JointKind, values: &[f64]) -> Vector3<f64> {
    let mut translation = Vector3::zeros();
    for (&axis, &value) in kind.translation_axes().iter().zip(values) {
        translation[axis] = value;
    }
    translation
}

/// The joint-frame axis of the n-th free rotation.
#[inline]
pub fn rotation_axis(kind: JointKind, number: usize) -> usize {
    if kind.rotation() == FreeRotation::AboutZ { 2 } else { number }
}

/// `F Rz(angle)`.
#[inline(always)]
pub fn rotate_about_z(frame: &Matrix3<f64>, angle: f64) -> Matrix3<f64> {
    let (sine, cosine) = angle.sin_cos();
    let (x, y) = (column(frame, 0), column(frame, 1));
    from_columns(&(x * cosine + y * sine), &(y * cosine - x * sine), &column(frame, 2))
}

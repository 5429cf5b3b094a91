//! The constants of bodies and links, in the joint frames.

use catena_mechanism::description::joint::{JointKind, Pose, wxyz_from_rotation};
use catena_mechanism::description::mechanism::Body;
use nalgebra::Matrix3;

/// A frame on a body's joint frame: translation (m) and unit quaternion.
#[derive(Clone)]
pub(crate) struct FixedFrame {
    /// Entry of the motion, where the world is entry 0.
    pub on: usize,
    pub translation: [f64; 3],
    pub turn: [f64; 4],
}

/// The constants of a body in its joint frame, as in the articulated-body algorithm.
#[derive(Clone)]
pub(crate) struct Constants {
    pub kind: JointKind,
    /// The joint frame on the parent, seen from the parent's joint frame.
    pub mount: FixedFrame,
    pub position_index: usize,
    pub velocity_index: usize,
    /// (kg)
    pub mass: f64,
    /// Mass times the arm from the anchor to the centre of mass [kg m].
    pub moment: [f64; 3],
    /// About the anchor: xx, xy, xz, yy, yz, zz [kg m²].
    pub inertia: [f64; 6],
}

impl FixedFrame {
    pub(crate) fn new(on: usize, pose: &Pose) -> Self {
        FixedFrame { on, translation: pose.translation.vector.into(), turn: wxyz_from_rotation(pose.rotation.matrix()) }
    }
}

impl Constants {
    pub(crate) fn new(bodies: &[Body], index: usize) -> Self {
        let body = &bodies[index];
        let joint = &body.joint;
        let frame_on_child = joint.on_child.rotation.matrix();
        let centre = -(frame_on_child.transpose() * joint.on_child.translation.vector);
        let steiner = Matrix3::identity() * centre.norm_squared() - centre * centre.transpose();
        let principal = Matrix3::from_diagonal(&body.inertia);
        let inertia = frame_on_child.transpose() * principal * frame_on_child + steiner * body.mass;
        Constants {
            kind: joint.kind,
            mount: match body.parent {
                None => FixedFrame::new(0, &joint.on_parent),
                Some(parent) => {
                    FixedFrame::new(parent + 1, &(bodies[parent].joint.on_child.inverse() * joint.on_parent))
                }
            },
            position_index: joint.position_index,
            velocity_index: joint.velocity_index,
            mass: body.mass,
            moment: (centre * body.mass).into(),
            inertia: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|entry| inertia[entry]),
        }
    }
}

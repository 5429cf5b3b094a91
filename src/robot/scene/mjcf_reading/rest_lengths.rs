//! Lengths of tendons at which their springs are free, and points that never move against each other.
//!
//! MuJoCo takes the length of a spatial tendon without `springlength` with each joint at its `springref`, also where the joint has no spring. Bodies are
//! described with each joint at its `ref`, so that the pose P of a body follows from the pose of its parent:
//!
//! ```text
//!     P = P_parent B J(springref − ref)          J: turn about the axis of a hinge [rad], shift along the axis of a slide [m]
//! ```
//!
//! with the frame B of the joint in the parent. Ball joints and free joints are as described.
//!
//! Source: MuJoCo documentation, XML reference, `tendon/spatial/springlength` and `joint/springref`.

use crate::scene::mjcf_reading::parts::{End, Joint, Tree};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::robot::{Pose, UrdfJointKind};
use nalgebra::{Point3, Rotation3, Translation3, Unit, Vector3};

impl Reader<'_> {
    /// The distance of two points with each joint at its `springref` [m].
    pub fn rest_length(&self, ends: &[End; 2]) -> f64 {
        let [a, b] = ends.each_ref().map(|(body, point)| {
            let pose = body.as_ref().and_then(|body| Some(self.tree_of(body)?.pose_at_rest(body)));
            pose.unwrap_or_default() * Point3::from(*point)
        });
        (b - a).norm()
    }

    /// Whether points never move against each other.
    pub fn are_one_body(&self, ends: &[End]) -> bool {
        let rigid = |(body, _): &End| {
            let body = body.as_ref()?;
            let tree = self.placed.get(body)?.tree?;
            Some((tree, self.trees[tree].rigid_with(body)?.to_string()))
        };
        let mut bodies = ends.iter().map(rigid);
        let first = bodies.next();
        bodies.all(|body| Some(body) == first)
    }

    fn tree_of(&self, body: &str) -> Option<&Tree> {
        self.placed.get(body)?.tree.map(|tree| &self.trees[tree])
    }
}

impl Tree {
    /// The pose of a link in the world with each joint at its `springref`.
    fn pose_at_rest(&self, link: &str) -> Pose {
        match self.joints.iter().find(|(between, _)| between.child == link) {
            Some((between, joint)) => {
                let moved = joint.as_ref().map_or_else(Pose::identity, Joint::displaced_to_rest);
                self.pose_at_rest(&between.parent) * between.origin * moved
            }
            None => self.pose,
        }
    }

    /// The first link of the rigid body of a link; `None` if it is fixed in the world.
    fn rigid_with<'t>(&'t self, link: &'t str) -> Option<&'t str> {
        match self.joints.iter().find(|(between, _)| between.child == link) {
            Some((_, Some(_))) => Some(link),
            Some((between, None)) => self.rigid_with(&between.parent),
            None => self.floats.then_some(link),
        }
    }
}

impl Joint {
    /// The displacement from `ref` to `springref`.
    fn displaced_to_rest(&self) -> Pose {
        let turned = |by: f64| Rotation3::from_axis_angle(&Unit::new_unchecked(self.axis), by);
        match self.kind {
            UrdfJointKind::Prismatic => {
                Pose::from_parts(Translation3::from(self.rest * self.axis), Rotation3::identity())
            }
            UrdfJointKind::Spherical => Pose::identity(),
            _ => Pose::from_parts(Translation3::from(Vector3::zeros()), turned(self.rest)),
        }
    }
}

//! The loops of scene files and of `<loop_joint>` elements, as joints between frames of bodies.
//!
//! The axis of an end becomes `z` of its frame, and [`axis_rotation`] gives `x` and `y`. If more than the axis counts, the start of the scene file
//! decides, so that a closed start stays closed:
//!
//! * prismatic, fixed: `x_b` is `x_a`, made orthogonal to `z_b`;
//! * fixed without axes: all of frame `b` is parallel to frame `a`;
//! * distance without a length: the distance.
//!
//! The start is the start of the file: positions given on the command line move the bodies and not the frames in them. A `<loop_joint>` gives both
//! frames whole. Its `world`, if no link has that name, is the world in which the robot's base has its pose, as for the joints of the tree.

use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::closure::{LoopJoint, LoopKind};
use crate::mechanism::description::joint::Pose;
use crate::mechanism::motion::gaps::loop_gaps;
use crate::mechanism::motion::kinematics::forward_kinematics;
use crate::mechanism::structure::definiteness::odd_position;
use crate::model::coupling::builder::{Builder, End, Stand};
use crate::model::description::coupling_error::CouplingProblem;
use crate::model::description::model_error::ModelError;
use crate::model::reduction::joint_frame::axis_rotation;
use crate::scene::{Element, LinkReference, LoopEnd, LoopType, SceneLoop, UrdfLoopEnd};
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// A loop is closed if its gap [m, rad] is below this: far above rounding, far below what anyone can build.
const CLOSED: f64 = 1e-9;

impl Builder<'_> {
    /// The loops of the robots' own files.
    pub(crate) fn urdf_loops(&self) -> Result<Vec<LoopJoint>, ModelError> {
        let mut loops = Vec::new();
        for (number, placed) in self.model.robots.iter().enumerate() {
            for closing in &placed.robot.loops {
                let stand = Stand {
                    file: placed.robot.path.clone(),
                    line: closing.line,
                    element: Element::Loop(closing.name.clone()),
                };
                let turn = axis_rotation(&closing.axis);
                let end = |end: &UrdfLoopEnd| match end.link {
                    Some(link) => self.end(LinkReference::Link { robot: number, link }, &(end.origin * turn), &stand),
                    None => self.end(LinkReference::World, &(placed.base_pose * end.origin * turn), &stand),
                };
                let name = format!("{}{}", placed.prefix, closing.name);
                let (a, b) = (end(&closing.a)?, end(&closing.b)?);
                let kind = self.kind(closing.kind, None, &a, &b, &stand)?;
                loops.push(self.checked(LoopJoint { name, kind, a: a.attachment, b: b.attachment }, &a, &b, &stand)?);
            }
        }
        Ok(loops)
    }

    /// Adds the loops of the scene file to the loops of the robots.
    pub(crate) fn add_scene_loops(&self, loops: &mut Vec<LoopJoint>) -> Result<(), ModelError> {
        for closing in self.scene.iter().flat_map(|scene| &scene.loops) {
            if loops.iter().any(|other| other.name == closing.name) {
                let stand = self.stand(closing.line, Element::Loop(closing.name.clone()));
                return Err(stand.refuse(CouplingProblem::NameTaken));
            }
            loops.push(self.scene_loop(closing)?);
        }
        Ok(())
    }

    fn scene_loop(&self, closing: &SceneLoop) -> Result<LoopJoint, ModelError> {
        let stand = self.stand(closing.line, Element::Loop(closing.name.clone()));
        let end = |end: &LoopEnd| {
            let turn = axis_rotation(&end.axis.unwrap_or(Vector3::z()));
            let frame = Pose::from_parts(Translation3::from(end.point.position), turn);
            self.end(end.point.link, &frame, &stand)
        };
        let (a, mut b) = (end(&closing.a)?, end(&closing.b)?);
        let kind = self.kind(closing.kind, closing.length, &a, &b, &stand)?;
        let (_, axes_a) = a.attachment.place(self.bodies);
        let (_, axes_b) = b.attachment.place(self.bodies);
        let wanted = match closing.kind {
            LoopType::Fixed if closing.a.axis.is_none() => axes_a,
            LoopType::Fixed | LoopType::Prismatic => turned_towards(&axes_b, &axes_a.column(0).into_owned()),
            _ => axes_b,
        };
        if wanted != axes_b {
            let body = b.attachment.body.map_or(&WORLD, |body| &self.bodies[body]);
            let turn = Rotation3::from_matrix_unchecked(body.rotation.transpose() * wanted);
            b.attachment.frame = Pose::from_parts(b.attachment.frame.translation, turn);
        }
        self.checked(LoopJoint { name: closing.name.clone(), kind, a: a.attachment, b: b.attachment }, &a, &b, &stand)
    }

    fn kind(
        &self,
        kind: LoopType,
        length: Option<f64>,
        a: &End,
        b: &End,
        stand: &Stand,
    ) -> Result<LoopKind, ModelError> {
        Ok(match kind {
            LoopType::Revolute => LoopKind::Revolute,
            LoopType::Prismatic => LoopKind::Prismatic,
            LoopType::Cylindrical => LoopKind::Cylindrical,
            LoopType::Universal => LoopKind::Universal,
            LoopType::Spherical => LoopKind::Spherical,
            LoopType::Planar => LoopKind::Planar,
            LoopType::Fixed => LoopKind::Fixed,
            LoopType::Distance => {
                let apart = || (b.attachment.place(self.bodies).0 - a.attachment.place(self.bodies).0).norm();
                match length.unwrap_or_else(apart) {
                    length if length > CLOSED => LoopKind::Distance(length),
                    _ => return Err(stand.refuse(CouplingProblem::ZeroDistance)),
                }
            }
        })
    }

    /// The loop, unless it is implied by the tree or contradictory.
    fn checked(&self, closing: LoopJoint, a: &End, b: &End, stand: &Stand) -> Result<LoopJoint, ModelError> {
        if self.model.joints.iter().any(|joint| joint.name == closing.name) {
            return Err(stand.refuse(CouplingProblem::NameTaken));
        }
        let gap_at = |bodies: &[BodyState]| loop_gaps(&closing, bodies).largest().0;
        let gap = gap_at(self.bodies);
        let (a, b) = (a.link.clone(), b.link.clone());
        if closing.a.body == closing.b.body {
            return Err(stand.refuse(match gap < CLOSED {
                true => CouplingProblem::ImpliedByBody { a, b },
                false => CouplingProblem::Contradictory { a, b, gap },
            }));
        }
        if gap < CLOSED && gap_at(&self.odd_bodies()) < CLOSED {
            return Err(stand.refuse(CouplingProblem::ImpliedByTree { a, b }));
        }
        Ok(closing)
    }

    /// The bodies with the joints at displacements that close no loop by accident.
    fn odd_bodies(&self) -> Vec<BodyState> {
        let mechanism = &self.model.mechanism;
        let mut bodies = vec![WORLD; mechanism.bodies.len()];
        forward_kinematics(mechanism, &odd_position(mechanism), &vec![0.0; mechanism.velocity_count], &mut bodies);
        bodies
    }
}

/// Axes with the same z, turned about it until x is as near to `x` as it can be.
fn turned_towards(axes: &Matrix3<f64>, x: &Vector3<f64>) -> Matrix3<f64> {
    let z = axes.column(2).into_owned();
    let across = x - z * z.dot(x);
    // Along z there is no nearest direction.
    if across.norm() < 1e-6 {
        return *axes;
    }
    let x = across.normalize();
    Matrix3::from_columns(&[x, z.cross(&x), z])
}

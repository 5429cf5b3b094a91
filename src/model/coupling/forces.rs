//! The springs and loads of scene files, as forces between frames of bodies and on coordinates of joints.

use crate::mechanism::description::forces::{JointDamper, JointLoad, JointSpring, PointSpring, Wrench};
use crate::mechanism::description::joint::Pose;
use crate::model::coupling::builder::Builder;
use crate::model::description::coupling_error::CouplingProblem;
use crate::model::description::model_error::ModelError;
use crate::scene::{Element, LoadKind, Point, SceneLoad, SceneSpring, SpringPlace};
use nalgebra::{Rotation3, Translation3, Vector3};

/// A spring of the scene file in the lists of the mechanism.
pub(crate) enum Spring {
    Points(PointSpring),
    Joint(Option<JointSpring>, Option<JointDamper>),
}

/// A load of the scene file in the lists of the mechanism.
pub(crate) enum Load {
    Joint(JointLoad),
    Link(Wrench),
}

impl Builder<'_> {
    /// A spring of the scene file.
    pub(crate) fn spring(&self, spring: &SceneSpring) -> Result<Spring, ModelError> {
        let stand = self.stand(spring.line, Element::Spring(spring.name.clone()));
        let SceneSpring { stiffness, damping, .. } = *spring;
        match &spring.place {
            SpringPlace::Points { a, b, rest_length } => {
                let end = |point: &Point| self.end(point.link, &frame_at(&point.position), &stand);
                let (a, b) = (end(a)?, end(b)?);
                if a.attachment.body == b.attachment.body {
                    return Err(stand.refuse(CouplingProblem::IdleSpring { a: a.link, b: b.link }));
                }
                let (name, rest_length) = (spring.name.clone(), *rest_length);
                let (a, b) = (a.attachment, b.attachment);
                Ok(Spring::Points(PointSpring { name, a, b, stiffness, damping, rest_length }))
            }
            SpringPlace::Joint { joint, rest } => {
                let coordinate = self.coordinate(joint.robot, &joint.joint, &stand)?;
                let spring = (stiffness > 0.0).then_some(JointSpring { coordinate, stiffness, rest: *rest });
                let damper = JointDamper { freedom: coordinate.freedom, coefficient: damping };
                Ok(Spring::Joint(spring, (damping > 0.0).then_some(damper)))
            }
        }
    }

    /// A load of the scene file.
    pub(crate) fn load(&self, load: &SceneLoad) -> Result<Load, ModelError> {
        let stand = self.stand(load.line, Element::Load(load.on.clone()));
        match &load.kind {
            LoadKind::Joint { joint, effort } => {
                let freedom = self.coordinate(joint.robot, &joint.joint, &stand)?.freedom;
                Ok(Load::Joint(JointLoad { freedom, effort: *effort }))
            }
            LoadKind::Link { point, force, torque } => {
                let end = self.end(point.link, &frame_at(&point.position), &stand)?;
                let Some(body) = end.attachment.body else {
                    return Err(stand.refuse(CouplingProblem::IdleLoad(end.link)));
                };
                let point = end.attachment.frame.translation.vector;
                Ok(Load::Link(Wrench { body, point, force: *force, torque: *torque }))
            }
        }
    }
}

/// A frame at a point, parallel to what the point is given in.
fn frame_at(point: &Vector3<f64>) -> Pose {
    Pose::from_parts(Translation3::from(*point), Rotation3::identity())
}

//! The springs and loads of scene files, as forces between frames of bodies and on coordinates of joints.

use crate::mechanism::description::course::Course;
use crate::mechanism::description::forces::{
    Drag, JointCourse, JointDamper, JointLoad, JointSpring, LinkLoad, PointSpring, Wrench,
};
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::target::Target;
use crate::model::coupling::builder::Builder;
use crate::model::description::coupling_error::CouplingProblem;
use crate::model::description::model_error::ModelError;
use crate::scene::{Element, Factor, LoadKind, Point, SceneDrag, SceneLoad, SceneSpring, SpringPlace};
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
    JointCourse(JointCourse),
    LinkLoad(LinkLoad),
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
        let course = course_of(load);
        match &load.kind {
            LoadKind::Joint { joint, effort } => {
                let (freedom, effort) = (self.coordinate(joint.robot, &joint.joint, &stand)?.freedom, *effort);
                Ok(match course {
                    None => Load::Joint(JointLoad { freedom, effort }),
                    Some(course) => Load::JointCourse(JointCourse { freedom, effort, course }),
                })
            }
            LoadKind::Link { point, force, torque, turns } => {
                let end = self.end(point.link, &frame_at(&point.position), &stand)?;
                let Some(body) = end.attachment.body else {
                    return Err(stand.refuse(CouplingProblem::IdleLoad(end.link)));
                };
                let frame = end.attachment.frame;
                let (point, force, torque) = (frame.translation.vector, *force, *torque);
                if !turns && course.is_none() {
                    return Ok(Load::Link(Wrench { body, point, force, torque }));
                }
                let turned = |own: Vector3<f64>| if *turns { frame.rotation * own } else { own };
                let course = course.unwrap_or_else(|| Course::constant(1.0));
                let (force, torque, turns) = (turned(force), turned(torque), *turns);
                Ok(Load::LinkLoad(LinkLoad { body, point, force, torque, turns, course }))
            }
        }
    }

    /// The drag of a link of the scene file.
    pub(crate) fn drag(&self, drag: &SceneDrag) -> Result<Drag, ModelError> {
        let stand = self.stand(drag.line, Element::Drag(drag.on.clone()));
        let end = self.end(drag.point.link, &frame_at(&drag.point.position), &stand)?;
        let Some(body) = end.attachment.body else {
            return Err(stand.refuse(CouplingProblem::IdleLoad(end.link)));
        };
        let [linear, quadratic, angular_linear, angular_quadratic] = drag.numbers;
        let point = end.attachment.frame.translation.vector;
        Ok(Drag { body, point, linear, quadratic, angular_linear, angular_quadratic })
    }
}

/// The factor of a load over time; `None` for one that always acts in full.
fn course_of(load: &SceneLoad) -> Option<Course> {
    let course = match &load.factor {
        Factor::None if load.from.is_none() && load.until.is_none() => return None,
        Factor::None => Course::constant(1.0),
        Factor::Number(factor) => Course::constant(*factor),
        // The reader has checked the table.
        Factor::Table(table) => Course::table(table.target().unwrap_or_else(|_| Target::constant(0.0))),
        Factor::Wave(wave) => Course::wave(*wave),
        Factor::Formula(formula) => Course::table(Target::formula(formula.clone())),
    };
    Some(course.between(load.from.unwrap_or(f64::NEG_INFINITY), load.until.unwrap_or(f64::INFINITY)))
}

/// A frame at a point, parallel to what the point is given in.
pub(crate) fn frame_at(point: &Vector3<f64>) -> Pose {
    Pose::from_parts(Translation3::from(*point), Rotation3::identity())
}

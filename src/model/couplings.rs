//! Fills the lists of a mechanism that the tree does not have: loops, mimic relations, and forces.
//!
//! A frame given in a link frame `L` (in its body, [`LinkFrame::in_body`](super::LinkFrame::in_body)) lies at `L X` in the
//! body. The axis of a loop's end becomes `z` of its frame, `x` and `y` those of [`axis_rotation`]. Where more than the
//! axis counts, the start of the scene file decides, so that a closed start stays closed:
//!
//! * prismatic, fixed: `x_b` is `x_a`, made orthogonal to `z_b`;
//! * fixed without axes: all of frame `b` is parallel to frame `a`;
//! * distance without a length: the distance.
//!
//! The start is that of the file: positions given on the command line move the bodies and not the frames in them.

use super::closure::{Attachment, Coordinate, LoopJoint, LoopKind, Mimic};
use super::coupling_error::{CouplingError, CouplingProblem};
use super::definiteness::odd_position;
use super::joint::{JointKind, Pose};
use super::joint_frame::axis_rotation;
use super::model_error::ModelError;
use super::robot_model::{JointRecord, Model};
use crate::forces::{JointDamper, JointLoad, JointSpring, PointSpring, Wrench};
use crate::kinematics::{WORLD, body_states, forward_kinematics};
use crate::scene::{
    DAMPING_IS_SIMULATED, Element, LinkReference, LoadKind, LoopEnd, LoopType, MIMIC_IS_SIMULATED, Point, Scene,
    SceneLoad, SceneLoop, SceneSpring, SpringPlace, UrdfJoint, UrdfJointKind, Warning,
};
use crate::state::{BodyState, State};
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A loop is closed if its gap [m, rad] is below this: far above rounding, far below what anyone can build.
const CLOSED: f64 = 1e-9;

impl Model {
    /// The one place where what files say of loops, mimic relations and forces becomes part of the mechanism.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line of the loop, spring, load or joint.
    pub(super) fn build_couplings(&mut self, scene: Option<&Scene>, start: &State) -> Result<(), ModelError> {
        let bodies = body_states(&self.mechanism, start);
        let above = self.joints_above();
        let dropped = |link: usize| self.is_dropped(link, &above);
        let builder = Builder { model: self, bodies: &bodies, dropped: &dropped, scene };
        let mut loops = builder.urdf_loops()?;
        loops.extend(builder.scene_loops()?);
        let mut forces = self.mechanism.forces.clone();
        for spring in scene.iter().flat_map(|scene| &scene.springs) {
            match builder.spring(spring)? {
                Spring::Points(spring) => forces.point_springs.push(spring),
                Spring::Joint(spring, damper) => {
                    forces.joint_springs.extend(spring);
                    forces.joint_dampers.extend(damper);
                }
            }
        }
        for load in scene.iter().flat_map(|scene| &scene.loads) {
            match builder.load(load)? {
                Load::Joint(load) => forces.joint_loads.push(load),
                Load::Link(wrench) => forces.wrenches.push(wrench),
            }
        }
        let mut warnings = Vec::new();
        if DAMPING_IS_SIMULATED {
            forces.joint_dampers.extend(builder.urdf_dampers(&mut warnings));
        }
        let mimics = if MIMIC_IS_SIMULATED { builder.urdf_mimics(&mut warnings)? } else { Vec::new() };
        self.mechanism.loops = loops;
        self.mechanism.mimics = mimics;
        self.mechanism.forces = forces;
        self.warnings.extend(warnings);
        Ok(())
    }

    /// The joint above each link that has one, by name.
    fn joints_above(&self) -> HashMap<String, usize> {
        self.joints.iter().enumerate().map(|(index, joint)| (joint.child_link.clone(), index)).collect()
    }

    /// Whether a link was held still because nothing beyond its joint has mass.
    fn is_dropped(&self, link: usize, above: &HashMap<String, usize>) -> bool {
        let mut joint = above.get(&self.links[link].name);
        while let Some(&index) = joint {
            let record = &self.joints[index];
            if record.kind != UrdfJointKind::Fixed && record.body.is_none() {
                return true;
            }
            joint = above.get(&record.parent_link).filter(|&&next| next != index);
        }
        false
    }
}

/// What all couplings look at.
struct Builder<'b> {
    model: &'b Model,
    /// Where the bodies start.
    bodies: &'b [BodyState],
    /// Whether a link was left out.
    dropped: &'b dyn Fn(usize) -> bool,
    scene: Option<&'b Scene>,
}

/// Where something stands in a file.
struct Stand {
    file: PathBuf,
    line: usize,
    element: Element,
}

/// One end of a loop: its frame, and the name of its link.
struct End {
    attachment: Attachment,
    link: String,
}

enum Spring {
    Points(PointSpring),
    Joint(Option<JointSpring>, Option<JointDamper>),
}

enum Load {
    Joint(JointLoad),
    Link(Wrench),
}

impl Stand {
    fn refuse(&self, problem: CouplingProblem) -> ModelError {
        let (file, line, element) = (self.file.clone(), self.line, self.element.clone());
        ModelError::Coupling(CouplingError { file, line, element, problem })
    }
}

impl Builder<'_> {
    /// Where something of the scene file stands.
    fn stand(&self, line: usize, element: Element) -> Stand {
        Stand { file: self.scene.map_or_else(PathBuf::new, |scene| scene.path.clone()), line, element }
    }

    /// The loops of the robots' own files.
    fn urdf_loops(&self) -> Result<Vec<LoopJoint>, ModelError> {
        let mut loops = Vec::new();
        for (number, placed) in self.model.robots.iter().enumerate() {
            for closing in &placed.robot.loops {
                let stand = Stand {
                    file: placed.robot.path.clone(),
                    line: closing.line,
                    element: Element::Loop(closing.name.clone()),
                };
                let turn = axis_rotation(&closing.axis);
                let end = |&(link, frame): &(Option<usize>, Pose)| {
                    let link = link.map_or(LinkReference::World, |link| LinkReference::Link { robot: number, link });
                    self.end(link, &(frame * turn), &stand)
                };
                let name = if self.model.robots.len() > 1 {
                    format!("{}/{}", placed.name, closing.name)
                } else {
                    closing.name.clone()
                };
                let (a, b) = (end(&closing.a)?, end(&closing.b)?);
                let kind = self.kind(closing.kind, None, &a, &b, &stand)?;
                loops.push(self.checked(LoopJoint { name, kind, a: a.attachment, b: b.attachment }, &a, &b, &stand)?);
            }
        }
        Ok(loops)
    }

    /// The loops of the scene file.
    fn scene_loops(&self) -> Result<Vec<LoopJoint>, ModelError> {
        self.scene.iter().flat_map(|scene| &scene.loops).map(|closing| self.scene_loop(closing)).collect()
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

    /// The frame of an end, given in its link, in its body.
    fn end(&self, link: LinkReference, frame: &Pose, stand: &Stand) -> Result<End, ModelError> {
        let LinkReference::Link { robot, link } = link else {
            return Ok(End { attachment: Attachment { body: None, frame: *frame }, link: "world".to_string() });
        };
        let (index, in_body) = self.model.link_of_robot(robot, link);
        let link = &self.model.links[index];
        if (self.dropped)(index) {
            return Err(stand.refuse(CouplingProblem::DroppedLink(link.name.clone())));
        }
        Ok(End { attachment: Attachment { body: link.body, frame: in_body * frame }, link: link.name.clone() })
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

    /// The loop, unless it says nothing or what cannot be.
    fn checked(&self, closing: LoopJoint, a: &End, b: &End, stand: &Stand) -> Result<LoopJoint, ModelError> {
        let gap_at = |bodies: &[BodyState]| closing.gap(bodies).iter().fold(0.0_f64, |most, row| most.max(row.abs()));
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

    /// The bodies with the joints at displacements that close nothing by accident.
    fn odd_bodies(&self) -> Vec<BodyState> {
        let mechanism = &self.model.mechanism;
        let mut bodies = vec![WORLD; mechanism.bodies.len()];
        forward_kinematics(mechanism, &odd_position(mechanism), &vec![0.0; mechanism.velocity_count], &mut bodies);
        bodies
    }

    fn spring(&self, spring: &SceneSpring) -> Result<Spring, ModelError> {
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

    fn load(&self, load: &SceneLoad) -> Result<Load, ModelError> {
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

    /// What became of a joint of a robot.
    fn record(&self, robot: usize, joint: &str) -> Option<&JointRecord> {
        let placed = &self.model.robots[robot];
        // Records are in the order of the file, a floating base before them.
        let index = placed.robot.joints.iter().position(|other| other.name == joint)?;
        let records = &self.model.joints[placed.joints.clone()];
        records.get(index + usize::from(records.first().is_some_and(|record| record.is_base)))
    }

    /// The one coordinate of a joint.
    fn coordinate(&self, robot: usize, joint: &str, stand: &Stand) -> Result<Coordinate, ModelError> {
        let refuse = |reason| stand.refuse(CouplingProblem::NotScalar { joint: joint.to_string(), reason });
        let record = self.record(robot, joint).ok_or_else(|| refuse("does not exist"))?;
        let reason =
            if record.kind == UrdfJointKind::Fixed { "is fixed" } else { "is not simulated: it moves no mass" };
        let body = record.body.ok_or_else(|| refuse(reason))?;
        let joint = &self.model.mechanism.bodies[body].joint;
        match joint.kind {
            JointKind::Revolute | JointKind::Prismatic => {
                Ok(Coordinate { body, position: joint.position_index, freedom: joint.velocity_index })
            }
            _ => Err(refuse("has several degrees of freedom")),
        }
    }

    /// Every joint of a URDF with its robot.
    fn urdf_joints(&self) -> impl Iterator<Item = (usize, &Path, &UrdfJoint)> {
        let robots = self.model.robots.iter().enumerate();
        robots.flat_map(|(number, placed)| {
            placed.robot.joints.iter().map(move |joint| (number, placed.robot.path.as_path(), joint))
        })
    }

    /// The dampers of `<dynamics damping>`.
    fn urdf_dampers(&self, warnings: &mut Vec<Warning>) -> Vec<JointDamper> {
        let mut dampers = Vec::new();
        for (robot, file, joint) in self.urdf_joints() {
            let coefficient = joint.dynamics.map_or(0.0, |dynamics| dynamics.damping);
            let stand =
                Stand { file: file.to_path_buf(), line: joint.line, element: Element::Joint(joint.name.clone()) };
            let moves = self.record(robot, &joint.name).is_some_and(|record| record.body.is_some());
            if coefficient == 0.0 || !moves {
                continue;
            }
            match self.coordinate(robot, &joint.name, &stand) {
                Ok(_) if coefficient < 0.0 => {
                    warnings.push(warning(&stand, "its damping is negative, which would feed energy; it is not used"));
                }
                Ok(coordinate) => dampers.push(JointDamper { freedom: coordinate.freedom, coefficient }),
                Err(_) => {
                    let message = "damping is only simulated in joints that turn about or slide along an axis";
                    warnings.push(warning(&stand, message));
                }
            }
        }
        dampers
    }

    /// The relations of `<mimic>`.
    fn urdf_mimics(&self, warnings: &mut Vec<Warning>) -> Result<Vec<Mimic>, ModelError> {
        let mut mimics = Vec::new();
        for (robot, file, joint) in self.urdf_joints() {
            let Some(mimic) = &joint.mimic else { continue };
            let stand =
                Stand { file: file.to_path_buf(), line: joint.line, element: Element::Joint(joint.name.clone()) };
            let joints = &self.model.robots[robot].robot.joints;
            let leader_of = |name: &str| joints.iter().find(|other| other.name == name);
            let leader = leader_of(&mimic.joint)
                .ok_or_else(|| stand.refuse(CouplingProblem::UnknownLeader(mimic.joint.clone())))?;
            // A chain of leaders that is longer than the list of joints goes round in a circle.
            let mut next = Some(leader);
            for _ in 0..=joints.len() {
                next = next.and_then(|joint| leader_of(&joint.mimic.as_ref()?.joint));
            }
            if next.is_some() {
                return Err(stand.refuse(CouplingProblem::MimicCircle(mimic.joint.clone())));
            }
            let moves = |name: &str| self.record(robot, name).is_some_and(|record| record.body.is_some());
            if !moves(&joint.name) || !moves(&leader.name) {
                let still = if moves(&joint.name) { &leader.name } else { &joint.name };
                let message = format!("its mimic relation is not simulated, because joint {still:?} does not move");
                warnings.push(warning(&stand, &message));
                continue;
            }
            mimics.push(Mimic {
                name: self.record(robot, &joint.name).map_or_else(String::new, |record| record.name.clone()),
                follower: self.coordinate(robot, &joint.name, &stand)?,
                leader: self.coordinate(robot, &leader.name, &stand)?,
                multiplier: mimic.multiplier,
                offset: mimic.offset,
            });
        }
        Ok(mimics)
    }
}

fn warning(stand: &Stand, message: &str) -> Warning {
    let (file, element) = (stand.file.clone(), Some(stand.element.clone()));
    Warning { file, line: Some(stand.line), element, message: message.to_string() }
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

/// A frame at a point, parallel to what the point is given in.
fn frame_at(point: &Vector3<f64>) -> Pose {
    Pose::from_parts(Translation3::from(*point), Rotation3::identity())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ModelOptions;
    use crate::scene::{PackagePath, robot_from_text};

    /// A chain of hinges, of which `joint2` and `joint3` may say more about themselves.
    fn chain(second: &str, third: &str) -> Model {
        let inertial = "<inertial><origin xyz='0 0 -1'/><mass value='1'/>\
             <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>";
        let link = |index: usize| format!("<link name='link{index}'>{inertial}</link>");
        let joint = |index: usize, kind: &str, more: &str| {
            let parent = index - 1;
            format!(
                "<joint name='joint{index}' type='{kind}'><parent link='link{parent}'/><child link='link{index}'/>{more}</joint>"
            )
        };
        let text = format!(
            "<robot name='chain'><link name='link0'/>{}{}{}<link name='link4'/>{}{}{}{}</robot>",
            link(1),
            link(2),
            link(3),
            joint(1, "spherical", "<dynamics damping='5'/>"),
            joint(2, "continuous", second),
            joint(3, "continuous", third),
            joint(4, "continuous", "<dynamics damping='5'/>")
        );
        let robot = robot_from_text(&text, Path::new("chain.urdf"), &PackagePath::default()).expect("a robot");
        Model::new(robot, &ModelOptions::default()).expect("a model")
    }

    fn build<T>(model: &Model, what: impl Fn(&Builder, &mut Vec<Warning>) -> T) -> (T, Vec<String>) {
        let builder = Builder { model, bodies: &[], dropped: &|_| false, scene: None };
        let mut warnings = Vec::new();
        let built = what(&builder, &mut warnings);
        (built, warnings.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn damping_of_hinges_becomes_dampers_and_the_rest_is_warned_of() {
        let model = chain("<dynamics damping='0.5'/>", "<dynamics damping='-1'/>");
        let (dampers, warnings) = build(&model, |builder, warnings| builder.urdf_dampers(warnings));
        assert_eq!(dampers, [JointDamper { freedom: 3, coefficient: 0.5 }]);
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(warnings[0].contains("joint \"joint1\": damping is only simulated"), "{warnings:?}");
        assert!(warnings[1].contains("joint \"joint3\": its damping is negative"), "{warnings:?}");
    }

    #[test]
    fn mimic_relations_know_both_coordinates() {
        let model = chain("", "<mimic joint='joint2' multiplier='-2' offset='0.5'/>");
        let (mimics, warnings) = build(&model, |builder, warnings| builder.urdf_mimics(warnings));
        assert!(warnings.is_empty(), "{warnings:?}");
        let expected = Mimic {
            name: "joint3".to_string(),
            follower: Coordinate { body: 2, position: 5, freedom: 4 },
            leader: Coordinate { body: 1, position: 4, freedom: 3 },
            multiplier: -2.0,
            offset: 0.5,
        };
        assert_eq!(mimics.expect("good relations"), [expected]);
    }

    #[test]
    fn mimic_relations_that_cannot_be_are_refused_or_left_out_with_a_warning() {
        for (second, third, message) in [
            ("", "<mimic joint='joint9'/>", "mimics joint \"joint9\", which does not exist"),
            ("", "<mimic joint='joint3'/>", "mimics itself"),
            ("<mimic joint='joint3'/>", "<mimic joint='joint2'/>", "mimics itself"),
            ("", "<mimic joint='joint1'/>", "\"joint1\" has several degrees of freedom"),
        ] {
            let model = chain(second, third);
            let (mimics, _) = build(&model, |builder, warnings| builder.urdf_mimics(warnings));
            let error = mimics.expect_err(message).to_string();
            assert!(error.starts_with("chain.urdf:1: joint ") && error.contains(message), "{error}");
        }
        let model = chain("", "<mimic joint='joint4'/>");
        let (mimics, warnings) = build(&model, |builder, warnings| builder.urdf_mimics(warnings));
        assert_eq!(mimics.expect("a warning only").len(), 0);
        assert!(warnings.len() == 1 && warnings[0].contains("joint \"joint4\" does not move"), "{warnings:?}");
    }
}

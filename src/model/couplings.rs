//! Fills the lists of a mechanism that the tree does not have: loops, mimic relations, and forces.
//!
//! A frame given in a link frame `L` (in its body, [`LinkFrame::in_body`](crate::model::LinkFrame::in_body)) lies at `L X` in the
//! body, or in the world. What becomes of each kind is in `coupling_loops`, `coupling_forces` and `coupling_joints`.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::{Attachment, Coordinate};
use crate::mechanism::description::joint::{JointKind, Pose};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::coupling_error::{CouplingError, CouplingProblem};
use crate::model::coupling_forces::{Load, Spring};
use crate::model::model_error::ModelError;
use crate::model::robot_model::{JointRecord, Model};
use crate::scene::{Element, LinkReference, Scene, UrdfJointKind, WORLD_LINK};
use std::collections::HashMap;
use std::path::PathBuf;

impl Model {
    /// The one place where what files say of loops, mimic relations and forces becomes part of the mechanism.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line of the loop, spring, load or joint.
    pub(crate) fn build_couplings(&mut self, scene: Option<&Scene>, start: &State) -> Result<(), ModelError> {
        let bodies = body_states(&self.mechanism, start);
        let above = self.joints_above();
        let dropped = |link: usize| self.is_dropped(link, &above);
        let builder = Builder { model: self, bodies: &bodies, dropped: &dropped, scene };
        let mut loops = builder.urdf_loops()?;
        builder.add_scene_loops(&mut loops)?;
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
        forces.joint_dampers.extend(builder.urdf_dampers(&mut warnings));
        let mimics = builder.urdf_mimics(&mut warnings)?;
        let limits = builder.urdf_limits();
        self.mechanism.loops = loops;
        self.mechanism.mimics = mimics;
        self.mechanism.limits = limits;
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
            // A link may have the name of the world, in which the base floats.
            joint = if record.is_base { None } else { above.get(&record.parent_link) };
        }
        false
    }
}

/// What all couplings look at.
pub(crate) struct Builder<'b> {
    pub model: &'b Model,
    /// Where the bodies start.
    pub bodies: &'b [BodyState],
    /// Whether a link was left out.
    pub dropped: &'b dyn Fn(usize) -> bool,
    pub scene: Option<&'b Scene>,
}

/// Where something stands in a file.
pub(crate) struct Stand {
    pub file: PathBuf,
    pub line: usize,
    pub element: Element,
}

/// One end of a loop or spring: its frame, and the name of its link.
pub(crate) struct End {
    pub attachment: Attachment,
    pub link: String,
}

impl Stand {
    /// The error that this is wrong with it.
    pub(crate) fn refuse(&self, problem: CouplingProblem) -> ModelError {
        let (file, line, element) = (self.file.clone(), self.line, self.element.clone());
        ModelError::Coupling(CouplingError { file, line, element, problem })
    }
}

impl Builder<'_> {
    /// Where something of the scene file stands.
    pub(crate) fn stand(&self, line: usize, element: Element) -> Stand {
        Stand { file: self.scene.map_or_else(PathBuf::new, |scene| scene.path.clone()), line, element }
    }

    /// The frame of an end, given in its link, in its body.
    pub(crate) fn end(&self, link: LinkReference, frame: &Pose, stand: &Stand) -> Result<End, ModelError> {
        let end = match link {
            LinkReference::World => {
                End { attachment: Attachment { body: None, frame: *frame }, link: WORLD_LINK.to_string() }
            }
            LinkReference::Link { robot, link } => {
                let (index, in_body) = self.model.link_of_robot(robot, link);
                let link = &self.model.links[index];
                if (self.dropped)(index) {
                    return Err(stand.refuse(CouplingProblem::DroppedLink(link.name.clone())));
                }
                End { attachment: Attachment { body: link.body, frame: in_body * frame }, link: link.name.clone() }
            }
        };
        // Squares of distances are what loops and springs compute with.
        if !end.attachment.place(self.bodies).0.norm_squared().is_finite() {
            return Err(stand.refuse(CouplingProblem::TooFar(end.link)));
        }
        Ok(end)
    }

    /// What became of a joint of a robot.
    pub(crate) fn record(&self, robot: usize, joint: &str) -> Option<&JointRecord> {
        let placed = &self.model.robots[robot];
        // Records are in the order of the file, a floating base before them.
        let index = placed.robot.joints.iter().position(|other| other.name == joint)?;
        let records = &self.model.joints[placed.joints.clone()];
        records.get(index + usize::from(records.first().is_some_and(|record| record.is_base)))
    }

    /// The one coordinate of a joint.
    pub(crate) fn coordinate(&self, robot: usize, joint: &str, stand: &Stand) -> Result<Coordinate, ModelError> {
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
}

//! What every coupling of a file looks at while it becomes part of the mechanism: links, frames, coordinates, and where it stands in its file.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::{Attachment, Coordinate};
use crate::mechanism::description::joint::JointKind;
use crate::model::coupling_error::{CouplingError, CouplingProblem};
use crate::model::model_error::ModelError;
use crate::model::robot_model::{JointRecord, Model};
use crate::scene::Scene;
use crate::scene::coupling::LinkReference;
use crate::scene::error::Element;
use crate::scene::robot::{Pose, UrdfJointKind};
use crate::scene::schema::WORLD_LINK;
use std::path::PathBuf;
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

//! Shared lookups while the couplings of a file are added to the mechanism: links, frames, coordinates, and lines of the file.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::{Attachment, Coordinate};
use crate::mechanism::description::joint::JointKind;
use crate::model::description::coupling_error::{CouplingError, CouplingProblem};
use crate::model::description::model_error::ModelError;
use crate::model::description::robot_model::{JointRecord, Model};
use crate::scene::Scene;
use crate::scene::coupling::LinkReference;
use crate::scene::robot::{Pose, UrdfJoint, UrdfJointKind};
use crate::scene::world::WORLD_LINK;
use crate::scene::{Element, Warning};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The common data of all couplings.
pub(crate) struct Builder<'b> {
    pub model: &'b Model,
    /// The bodies at the start.
    pub bodies: &'b [BodyState],
    /// Whether a link was left out.
    pub dropped: &'b dyn Fn(usize) -> bool,
    pub scene: Option<&'b Scene>,
}

/// A place in a file, for messages.
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

    /// The warning that this is to be known of it.
    pub(crate) fn warning(&self, message: &str) -> Warning {
        Warning::odd(&self.file, Some(self.line), Some(self.element.clone()), message)
    }
}

impl Builder<'_> {
    /// A place in the scene file.
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

    /// Every joint of a URDF.
    pub(crate) fn urdf_joints(&self) -> impl Iterator<Item = UrdfJointOf<'_>> {
        self.model.robots.iter().enumerate().flat_map(|(robot, placed)| {
            let records = self.records(robot);
            let joints = placed.robot.joints.iter().enumerate();
            joints.map(move |(index, joint)| UrdfJointOf {
                robot,
                file: placed.robot.path.as_path(),
                joint,
                record: records.get(index),
            })
        })
    }

    /// The record of a joint of a robot.
    pub(crate) fn record(&self, robot: usize, joint: &str) -> Option<&JointRecord> {
        let index = self.model.robots[robot].robot.joints.iter().position(|other| other.name == joint)?;
        self.records(robot).get(index)
    }

    /// The records of the joints of a URDF, in the order of the file.
    fn records(&self, robot: usize) -> &[JointRecord] {
        let records = &self.model.joints[self.model.robots[robot].joints.clone()];
        // A floating base comes before them.
        &records[usize::from(records.first().is_some_and(|record| record.is_base))..]
    }

    /// The one coordinate of a joint.
    pub(crate) fn coordinate(&self, robot: usize, joint: &str, stand: &Stand) -> Result<Coordinate, ModelError> {
        let coordinate = self.record(robot, joint).ok_or("does not exist").and_then(|record| self.scalar(record));
        coordinate.map_err(|reason| stand.refuse(CouplingProblem::NotScalar { joint: joint.to_string(), reason }))
    }

    /// The one coordinate of a joint, or the reason why it is not one.
    fn scalar(&self, record: &JointRecord) -> Result<Coordinate, &'static str> {
        let reason =
            if record.kind == UrdfJointKind::Fixed { "is fixed" } else { "is not simulated: it moves no mass" };
        let body = record.body.ok_or(reason)?;
        let joint = &self.model.mechanism.bodies[body].joint;
        match joint.kind {
            JointKind::Revolute | JointKind::Prismatic => {
                Ok(Coordinate { body, position: joint.position_index, freedom: joint.velocity_index })
            }
            _ => Err("has several degrees of freedom"),
        }
    }
}

/// A joint of a URDF, and what became of it.
pub(crate) struct UrdfJointOf<'b> {
    pub robot: usize,
    pub file: &'b Path,
    pub joint: &'b UrdfJoint,
    pub record: Option<&'b JointRecord>,
}

impl UrdfJointOf<'_> {
    /// Its place in the file.
    pub(crate) fn stand(&self) -> Stand {
        let element = Element::Joint(self.joint.name.clone());
        Stand { file: self.file.to_path_buf(), line: self.joint.line, element }
    }

    /// Its one coordinate in the mechanism of `builder`; `None` if it is fixed, moves no mass, or has several freedoms.
    pub(crate) fn coordinate(&self, builder: &Builder) -> Option<Coordinate> {
        builder.scalar(self.record?).ok()
    }

    /// The freedoms that a damper of one coefficient acts along: of one coordinate, or of a ball; `None` of other joints.
    pub(crate) fn damped_freedoms(&self, builder: &Builder) -> Option<Range<usize>> {
        let joint = &builder.model.mechanism.bodies[self.record?.body?].joint;
        let first = joint.velocity_index;
        matches!(joint.kind, JointKind::Revolute | JointKind::Prismatic | JointKind::Spherical)
            .then(|| first..first + joint.kind.velocity_count())
    }

    /// Whether it moves anything.
    pub(crate) fn moves(&self) -> bool {
        self.record.is_some_and(|record| record.body.is_some())
    }
}

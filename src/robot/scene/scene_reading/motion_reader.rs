//! Joints that are moved in time, from the tables `[[motion]]`: names resolved, curves checked.
//!
//! The position of a moved joint needs a continuous rate, because a jump of the rate would be a blow without end of force. A table is a cubic spline
//! that begins and ends at rest; a formula is smooth.

use crate::mechanism::description::target::{Interpolation, Target};
use crate::scene::coupling::SceneLoop;
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::joint_settings::{SceneMotion, SceneMotor, TableFile};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::joint_schema::{MotionTable, TargetKey};
use crate::scene::scene_reading::scene_files::SceneFiles;
use crate::scene::scene_reading::scene_numbers::Quantity;
use std::ops::Range;
use toml::Spanned;

impl CouplingReader<'_> {
    /// All motions; the CSV files of their positions join `read`. Motors that a pattern names leave these joints alone.
    pub fn motions(
        &self,
        tables: Vec<Spanned<MotionTable>>,
        loops: &[SceneLoop],
        motors: &mut Vec<SceneMotor>,
        files: &mut dyn SceneFiles,
        read: &mut Vec<TableFile>,
    ) -> Result<Vec<SceneMotion>, SceneError> {
        let mut motions: Vec<SceneMotion> = Vec::with_capacity(tables.len());
        for table in tables {
            let MotionTable { joint: name, position } = table.into_inner();
            let owner = Element::Motion(name.get_ref().clone());
            let refuse = |span, message| Err(self.text.error(&span, Some(owner.clone()), Problem::Keys(message)));
            let joint = self.tree_joint(&name, loops, &owner)?;
            if let Some(first) = motions.iter().find(|other| other.joint == joint) {
                return Err(self.text.error(
                    &name.span(),
                    Some(owner),
                    Problem::SecondMotion { first_line: first.line },
                ));
            }
            if motors.iter().any(|motor| motor.joint == joint && !motor.lenient) {
                return refuse(
                    name.span(),
                    "the joint has a [[motor]], too; a joint that is moved needs none: leave one out",
                );
            }
            motors.retain(|motor| motor.joint != joint);
            let described = self.robots[joint.robot].robot.joints.iter().find(|other| other.name == joint.joint);
            if described.is_some_and(|described| described.mimic.is_some()) {
                return refuse(name.span(), "the joint mimics another one; move that one instead");
            }
            if matches!(position.get_ref(), TargetKey::Start) {
                let message = "its position is a number, a list of [time, value], the name of a CSV file of time,value, or { formula = \"…\" }";
                return refuse(position.span(), message);
            }
            let value = |given: Quantity, span: &Range<usize>| self.joint_number(&joint, given, false, span, &owner);
            let (target, table) = self.target(&position, &value, Interpolation::Cubic, &owner, files, read)?;
            let position = match &table {
                // Its times and values were checked above.
                Some(table) => Target::smooth(&table.points).unwrap_or(target),
                None => target,
            };
            let line = self.text.line(&name.span());
            motions.push(SceneMotion { joint, on: name.into_inner(), position, table, line });
        }
        Ok(motions)
    }
}

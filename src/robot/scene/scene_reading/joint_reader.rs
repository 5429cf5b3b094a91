//! Motors and settings of joints, from the tables `[[motor]]` and `[[joint]]`: names resolved, keys that belong together checked.

use crate::mechanism::description::nonsmooth::MotorLaw;
use crate::scene::coupling::{JointReference, SceneLoop};
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::joint_settings::{LimitChoice, SceneJoint, SceneMotor, TableFile};
use crate::scene::pattern::matches;
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::joint_schema::{JointTable, LimitKey, MotorKind, MotorTable, TargetKey};
use crate::scene::scene_reading::scene_files::SceneFiles;
use crate::scene::scene_reading::scene_numbers::Quantity;
use std::ops::Range;
use toml::Spanned;

/// A joint that a table drives.
struct Driven {
    /// The table, by its place among the motors.
    table: usize,
    joint: JointReference,
    /// Its name, as written; whole where a pattern names it.
    on: String,
    /// Whether a pattern names it.
    lenient: bool,
    line: usize,
}

impl CouplingReader<'_> {
    /// All motors; the CSV files of their targets join `tables`.
    pub fn motors(
        &self,
        tables: Vec<Spanned<MotorTable>>,
        loops: &[SceneLoop],
        files: &mut dyn SceneFiles,
        read: &mut Vec<TableFile>,
    ) -> Result<Vec<SceneMotor>, SceneError> {
        let driven = self.driven(&tables, loops)?;
        let mut motors: Vec<SceneMotor> = Vec::with_capacity(driven.len());
        for (number, table) in tables.into_iter().enumerate() {
            let (table_span, table) = (table.span(), table.into_inner());
            for driven in driven.iter().filter(|driven| driven.table == number) {
                motors.push(self.motor(&table, &table_span, driven, files, read)?);
            }
        }
        Ok(motors)
    }

    /// The joints that the tables drive. A table that names a joint goes before patterns, and a pattern before later ones.
    fn driven(&self, tables: &[Spanned<MotorTable>], loops: &[SceneLoop]) -> Result<Vec<Driven>, SceneError> {
        let mut all: Vec<Driven> = Vec::new();
        let names: Vec<(usize, &Spanned<String>)> = tables
            .iter()
            .enumerate()
            .flat_map(|(number, table)| table.get_ref().joint.0.iter().map(move |name| (number, name)))
            .collect();
        let is_pattern = |name: &Spanned<String>| name.get_ref().contains('*');
        for &(table, name) in names.iter().filter(|(_, name)| !is_pattern(name)) {
            let owner = Element::Motor(name.get_ref().clone());
            let joint = self.tree_joint(name, loops, &owner)?;
            let line = self.text.line(&name.span());
            if let Some(first) = all.iter().find(|other| other.joint == joint) {
                let problem = Problem::SecondMotor { first_line: first.line };
                return Err(self.text.error(&name.span(), Some(owner), problem));
            }
            all.push(Driven { table, joint, on: name.get_ref().clone(), lenient: false, line });
        }
        for &(table, name) in names.iter().filter(|(_, name)| is_pattern(name)) {
            let line = self.text.line(&name.span());
            let before = all.len();
            for (robot, placed) in self.robots.iter().enumerate() {
                for joint in placed.robot.joints.iter().filter(|joint| joint.can_be_driven()) {
                    let (on, joint) = (format!("{}{}", placed.prefix, joint.name), joint.name.clone());
                    // A scene with one robot may write its joints with its name, too.
                    let long = format!("{}/{joint}", placed.name);
                    let joint = JointReference { robot, joint };
                    if [&on, &long].iter().any(|full| matches(name.get_ref(), full))
                        && all.iter().all(|other| other.joint != joint)
                    {
                        all.push(Driven { table, joint, on, lenient: true, line });
                    }
                }
            }
            if all.len() == before {
                let owner = Some(Element::Motor(name.get_ref().clone()));
                let message = "no joint that turns about or slides along an axis, and has no other motor, is called so";
                return Err(self.text.error(&name.span(), owner, Problem::Keys(message)));
            }
        }
        Ok(all)
    }

    /// The motor of a table in one of the joints that it drives.
    fn motor(
        &self,
        table: &MotorTable,
        table_span: &Range<usize>,
        driven: &Driven,
        files: &mut dyn SceneFiles,
        read: &mut Vec<TableFile>,
    ) -> Result<SceneMotor, SceneError> {
        let Driven { joint, on, lenient, line, .. } = driven;
        let owner = Element::Motor(on.clone());
        let refuse = |span, message| Err(self.text.error(&span, Some(owner.clone()), Problem::Keys(message)));
        let law = match (table.kind, &table.kp, &table.kd) {
            (MotorKind::Position, Some(kp), kd) => {
                let kd = kd.as_ref().map_or(0.0, |kd| kd.get_ref().0);
                MotorLaw::Position { kp: kp.get_ref().0, kd }
            }
            (MotorKind::Position, None, _) => {
                return refuse(table_span.clone(), "a motor of the kind position needs its kp");
            }
            (MotorKind::Velocity, Some(kp), _) => {
                return refuse(kp.span(), "a motor of the kind velocity has a kd, no kp");
            }
            (MotorKind::Velocity, None, Some(kd)) => MotorLaw::Velocity { kd: kd.get_ref().0 },
            (MotorKind::Velocity, None, None) => {
                return refuse(table_span.clone(), "a motor of the kind velocity needs its kd");
            }
            (MotorKind::Effort, Some(gain), _) | (MotorKind::Effort, None, Some(gain)) => {
                return refuse(gain.span(), "a motor of the kind effort has neither kp nor kd");
            }
            (MotorKind::Effort, None, None) => MotorLaw::Effort,
        };
        let value = |given: Quantity, span: &Range<usize>| match table.kind {
            MotorKind::Effort => given.value(false, false).map_err(|reason| {
                let problem = Problem::JointNumber { joint: joint.joint.clone(), reason };
                self.text.error(span, Some(owner.clone()), problem)
            }),
            kind => self.joint_number(joint, given, kind == MotorKind::Velocity, span, &owner),
        };
        let (target, given) = self.target(&table.target, &value, table.interpolation.into(), &owner, files, read)?;
        let at_start = matches!(table.target.get_ref(), TargetKey::Start);
        if at_start && table.kind != MotorKind::Position {
            return refuse(table.target.span(), "only a motor of the kind position has the target \"start\"");
        }
        Ok(SceneMotor {
            joint: joint.clone(),
            on: on.clone(),
            law,
            target,
            at_start,
            frequency: None,
            lenient: *lenient,
            table: given,
            max_effort: table.max_effort.map(|bound| bound.0),
            period: table.period.map_or(0.0, |period| period.0),
            gravity_compensation: table.gravity_compensation.map_or(0.0, |part| part.0),
            line: *line,
        })
    }

    /// All settings of joints.
    pub fn joints(&self, tables: Vec<Spanned<JointTable>>, loops: &[SceneLoop]) -> Result<Vec<SceneJoint>, SceneError> {
        let mut joints: Vec<SceneJoint> = Vec::with_capacity(tables.len());
        for table in tables {
            let table_span = table.span();
            let JointTable { name, limit, restitution, friction, damping, armature } = table.into_inner();
            let owner = Element::Joint(name.get_ref().clone());
            let joint = self.tree_joint(&name, loops, &owner)?;
            if let Some(first) = joints.iter().find(|other| other.joint == joint) {
                let problem = Problem::SecondJoint { first_line: first.line };
                return Err(self.text.error(&name.span(), Some(owner), problem));
            }
            let refuse = |span, message| Err(self.text.error(&span, Some(owner.clone()), Problem::Keys(message)));
            let numbers = [friction, damping, armature];
            if limit.is_none() && restitution.is_none() && numbers.iter().all(Option::is_none) {
                return refuse(table_span, "give its limit, restitution, friction, damping or armature");
            }
            let number = |given: Quantity| self.joint_number(&joint, given, false, &name.span(), &owner);
            let limit = match limit {
                None => None,
                Some(LimitKey::Unlimited) => Some(LimitChoice::Unlimited),
                Some(LimitKey::Range([lower, upper])) => Some(LimitChoice::Range(number(lower.0)?, number(upper.0)?)),
            };
            if let (Some(LimitChoice::Unlimited), Some(restitution)) = (limit, &restitution) {
                return refuse(restitution.span(), "a joint without limits has no restitution");
            }
            joints.push(SceneJoint {
                joint,
                name: name.get_ref().clone(),
                limit,
                restitution: restitution.map(|restitution| restitution.get_ref().0),
                friction: friction.map(|friction| friction.0),
                damping: damping.map(|damping| damping.0),
                armature: armature.map(|armature| armature.0),
                line: self.text.line(&name.span()),
            });
        }
        Ok(joints)
    }

    /// A joint of the tree of a robot.
    pub(crate) fn tree_joint(
        &self,
        name: &Spanned<String>,
        loops: &[SceneLoop],
        owner: &Element,
    ) -> Result<JointReference, SceneError> {
        self.joint(name, owner).map_err(|unknown| {
            let of_scene = loops.iter().any(|closing| closing.name == *name.get_ref());
            let of_robot = self
                .called(name.get_ref())
                .any(|(robot, rest)| self.robots[robot].robot.loops.iter().any(|closing| closing.name == rest));
            if of_scene || of_robot {
                let problem = Problem::NotOfTree(name.get_ref().clone());
                return self.text.error(&name.span(), Some(owner.clone()), problem);
            }
            unknown
        })
    }
}

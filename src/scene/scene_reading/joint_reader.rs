//! Motors and settings of joints, from the tables `[[motor]]` and `[[joint]]`: names resolved, keys that belong together checked.

use crate::mechanism::description::nonsmooth::MotorLaw;
use crate::scene::coupling::{JointReference, SceneLoop};
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::joint_settings::{LimitChoice, SceneJoint, SceneMotor, TableFile};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::joint_schema::{JointTable, MotorKind, MotorTable};
use crate::scene::scene_reading::scene_files::SceneFiles;
use toml::Spanned;

impl CouplingReader<'_> {
    /// All motors; the CSV files of their targets join `tables`.
    pub fn motors(
        &self,
        tables: Vec<Spanned<MotorTable>>,
        loops: &[SceneLoop],
        files: &mut dyn SceneFiles,
        read: &mut Vec<TableFile>,
    ) -> Result<Vec<SceneMotor>, SceneError> {
        let mut motors: Vec<SceneMotor> = Vec::with_capacity(tables.len());
        for table in tables {
            let table_span = table.span();
            let table = table.into_inner();
            let on = table.joint.get_ref().clone();
            let owner = Element::Motor(on.clone());
            let joint = self.tree_joint(&table.joint, loops, &owner)?;
            if let Some(first) = motors.iter().find(|other| other.joint == joint) {
                let problem = Problem::SecondMotor { first_line: first.line };
                return Err(self.text.error(&table.joint.span(), Some(owner), problem));
            }
            let refuse = |span, message| Err(self.text.error(&span, Some(owner.clone()), Problem::Keys(message)));
            let law = match (table.kind, &table.kp, &table.kd) {
                (MotorKind::Position, Some(kp), kd) => {
                    let kd = kd.as_ref().map_or(0.0, |kd| kd.get_ref().0);
                    MotorLaw::Position { kp: kp.get_ref().0, kd }
                }
                (MotorKind::Position, None, _) => {
                    return refuse(table_span, "a motor of the kind position needs its kp");
                }
                (MotorKind::Velocity, Some(kp), _) => {
                    return refuse(kp.span(), "a motor of the kind velocity has a kd, no kp");
                }
                (MotorKind::Velocity, None, Some(kd)) => MotorLaw::Velocity { kd: kd.get_ref().0 },
                (MotorKind::Velocity, None, None) => {
                    return refuse(table_span, "a motor of the kind velocity needs its kd");
                }
                (MotorKind::Effort, Some(gain), _) | (MotorKind::Effort, None, Some(gain)) => {
                    return refuse(gain.span(), "a motor of the kind effort has neither kp nor kd");
                }
                (MotorKind::Effort, None, None) => MotorLaw::Effort,
            };
            let (target, given) = self.target(&table.target, table.interpolation.into(), &owner, files, read)?;
            motors.push(SceneMotor {
                joint,
                on,
                law,
                target,
                table: given,
                max_effort: table.max_effort.map(|bound| bound.0),
                period: table.period.map_or(0.0, |period| period.0),
                line: self.text.line(&table.joint.span()),
            });
        }
        Ok(motors)
    }

    /// All settings of joints.
    pub fn joints(&self, tables: Vec<Spanned<JointTable>>, loops: &[SceneLoop]) -> Result<Vec<SceneJoint>, SceneError> {
        let mut joints: Vec<SceneJoint> = Vec::with_capacity(tables.len());
        for table in tables {
            let table_span = table.span();
            let JointTable { name, limit, restitution, friction, damping } = table.into_inner();
            let owner = Element::Joint(name.get_ref().clone());
            let joint = self.tree_joint(&name, loops, &owner)?;
            if let Some(first) = joints.iter().find(|other| other.joint == joint) {
                let problem = Problem::SecondJoint { first_line: first.line };
                return Err(self.text.error(&name.span(), Some(owner), problem));
            }
            let refuse = |span, message| Err(self.text.error(&span, Some(owner.clone()), Problem::Keys(message)));
            if limit.is_none() && restitution.is_none() && friction.is_none() && damping.is_none() {
                return refuse(table_span, "give its limit, restitution, friction or damping");
            }
            let limit = limit.map(|limit| limit.0);
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
                line: self.text.line(&name.span()),
            });
        }
        Ok(joints)
    }

    /// A joint of the tree of a robot.
    fn tree_joint(
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

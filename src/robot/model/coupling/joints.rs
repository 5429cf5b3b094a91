//! Couplings that a URDF gives with its joints: `<dynamics damping>` and `<mimic>`.

use crate::mechanism::description::closure::Mimic;
use crate::mechanism::description::forces::JointDamper;
use crate::model::coupling::builder::Builder;
use crate::model::description::coupling_error::CouplingProblem;
use crate::model::description::model_error::ModelError;
use crate::scene::{UrdfJoint, UrdfJointKind, Warning};

impl Builder<'_> {
    /// The dampers of `<dynamics damping>`, or what a `[[joint]]` says instead: three in a ball joint, along the components of its angular velocity.
    pub(crate) fn dampers(&self, warnings: &mut Vec<Warning>) -> Vec<JointDamper> {
        let mut dampers = Vec::new();
        for of in self.urdf_joints() {
            let of_urdf = of.joint.dynamics.map_or(0.0, |dynamics| dynamics.damping);
            let coefficient = self.said(of.robot, &of.joint.name).and_then(|said| said.damping).unwrap_or(of_urdf);
            if coefficient == 0.0 || !of.moves() {
                continue;
            }
            match of.damped_freedoms(self) {
                Some(_) if coefficient < 0.0 => {
                    let message = "its damping is negative, which would add energy; ignored";
                    warnings.push(of.stand().warning(message));
                }
                Some(freedoms) => dampers.extend(freedoms.map(|freedom| JointDamper { freedom, coefficient })),
                None => {
                    let message =
                        "damping is only simulated in joints that turn about or slide along an axis, and in balls";
                    warnings.push(of.stand().warning(message));
                }
            }
        }
        dampers
    }

    /// The relations of `<mimic>`.
    pub(crate) fn urdf_mimics(&self, warnings: &mut Vec<Warning>) -> Result<Vec<Mimic>, ModelError> {
        let mut mimics = Vec::new();
        let (mut still, mut free) = (Vec::new(), Vec::new());
        for of in self.urdf_joints() {
            let Some(mimic) = &of.joint.mimic else { continue };
            let (robot, joint, stand) = (of.robot, of.joint, of.stand());
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
            let reason = |of: &UrdfJoint| if of.kind == UrdfJointKind::Fixed { "is fixed" } else { "moves no mass" };
            if !moves(&joint.name) {
                let (leader, reason) = (&leader.name, reason(joint));
                still.push(stand.warning(&format!("its <mimic> of joint {leader:?} is ignored, because it {reason}")));
                continue;
            }
            if !moves(&leader.name) {
                let (leader, reason) = (&leader.name, reason(leader));
                let message = format!("its <mimic> is ignored and it moves freely, because joint {leader:?} {reason}");
                free.push(stand.warning(&message));
                continue;
            }
            mimics.push(Mimic {
                name: self.record(robot, &joint.name).map_or_else(String::new, |record| record.name.clone()),
                follower: self.coordinate(robot, &joint.name, &stand)?,
                leader: self.coordinate(robot, &leader.name, &stand)?,
                multiplier: mimic.multiplier,
                offset: mimic.offset,
                more: Vec::new(),
                over_time: None,
            });
        }
        warnings.extend(Warning::of_kind(still, "joint", "joints"));
        warnings.extend(Warning::of_kind(free, "joint", "joints"));
        Ok(mimics)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::closure::Coordinate;
    use crate::model::{Model, ModelOptions};
    use crate::scene::{PackagePath, robot_from_text};
    use std::path::Path;

    /// A chain of hinges, of which `joint2` and `joint3` may say more about themselves.
    fn try_chain(second: &str, third: &str) -> Result<Model, ModelError> {
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
        Model::new(robot, &ModelOptions::default())
    }

    fn chain(second: &str, third: &str) -> Model {
        try_chain(second, third).expect("a model")
    }

    fn build<T>(model: &Model, what: impl Fn(&Builder, &mut Vec<Warning>) -> T) -> (T, Vec<String>) {
        let builder = Builder { model, bodies: &[], dropped: &|_| false, scene: None };
        let mut warnings = Vec::new();
        let built = what(&builder, &mut warnings);
        (built, warnings.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn damping_of_hinges_and_balls_becomes_dampers_and_what_is_negative_is_warned_of() {
        let model = chain("<dynamics damping='0.5'/>", "<dynamics damping='-1'/>");
        let (dampers, warnings) = build(&model, |builder, warnings| builder.dampers(warnings));
        let of = |freedom, coefficient| JointDamper { freedom, coefficient };
        assert_eq!(dampers, [of(0, 5.0), of(1, 5.0), of(2, 5.0), of(3, 0.5)]);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].contains("joint \"joint3\": its damping is negative"), "{warnings:?}");
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
            more: Vec::new(),
            over_time: None,
        };
        assert_eq!(mimics.expect("good relations"), [expected]);
    }

    #[test]
    fn fixed_joints_that_should_mimic_are_one_warning_that_counts_them() {
        let text = "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/>\
             <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link><link name='c'/><link name='d'/>\
             <joint name='turn' type='continuous'><parent link='a'/><child link='b'/></joint>\
             <joint name='left' type='fixed'><parent link='b'/><child link='c'/><mimic joint='turn'/></joint>\
             <joint name='right' type='fixed'><parent link='b'/><child link='d'/><mimic joint='turn'/></joint></robot>";
        let robot = robot_from_text(text, Path::new("r.urdf"), &PackagePath::default()).expect("a robot");
        let model = Model::new(robot, &ModelOptions::default()).expect("a model");
        let (_, warnings) = build(&model, |builder, warnings| builder.urdf_mimics(warnings));
        let expected = "r.urdf:1: joint \"left\": its <mimic> of joint \"turn\" is ignored, because it is fixed; the same for 1 more joint";
        assert_eq!(warnings, [expected]);
    }

    #[test]
    fn mimic_relations_that_cannot_be_are_refused_or_left_out_with_a_warning() {
        for (second, third, message) in [
            ("", "<mimic joint='joint9'/>", "mimics joint \"joint9\", which does not exist"),
            ("", "<mimic joint='joint3'/>", "mimics itself"),
            ("<mimic joint='joint3'/>", "<mimic joint='joint2'/>", "mimics itself"),
            ("", "<mimic joint='joint1'/>", "\"joint1\" has several degrees of freedom"),
        ] {
            let error = try_chain(second, third).expect_err(message).to_string();
            assert!(error.starts_with("chain.urdf:1: joint ") && error.contains(message), "{error}");
        }
        // A follower determines a joint that moves no mass, unless its multiplier is zero.
        let model = chain("", "<mimic joint='joint4'/>");
        let (mimics, warnings) = build(&model, |builder, warnings| builder.urdf_mimics(warnings));
        assert_eq!((mimics.expect("a relation").len(), warnings.len()), (1, 0), "{warnings:?}");
        let model = chain("", "<mimic joint='joint4' multiplier='0'/>");
        let (mimics, warnings) = build(&model, |builder, warnings| builder.urdf_mimics(warnings));
        assert_eq!(mimics.expect("a warning only").len(), 0);
        assert!(warnings.len() == 1 && warnings[0].contains("moves freely, because joint \"joint4\""), "{warnings:?}");
    }
}

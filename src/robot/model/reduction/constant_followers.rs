//! Joints that mimic a fixed joint: they stand still where their relation puts them.
//!
//! A fixed joint is always at zero, so its followers are at `multiplier · 0 + offset`; and so on along chains of followers.

use crate::mechanism::description::joint::Pose;
use crate::model::reduction::joint_frame::joint_kind;
use crate::scene::{Element, Robot, UrdfJoint, UrdfJointKind, Warning};
use nalgebra::{Rotation3, Translation3, Unit};
use std::collections::HashMap;

/// Makes every joint that turns about or slides along an axis, and follows a joint that never moves, a fixed one, and says so in
/// a warning of the robot.
pub fn fix_constant_followers(robot: &mut Robot) {
    let fixed = robot.joints.iter().filter(|joint| joint.kind == UrdfJointKind::Fixed);
    let mut constant: HashMap<String, f64> = fixed.map(|joint| (joint.name.clone(), 0.0)).collect();
    let mut warnings = Vec::new();
    // Followers may stand before their leaders, so passes are repeated until one finds no new follower.
    loop {
        let known = constant.len();
        for joint in &mut robot.joints {
            let Some((value, displacement)) = constant_displacement(joint, &constant) else { continue };
            let Some(mimic) = joint.mimic.take() else { continue };
            let unit = joint_kind(joint.kind).map_or("", |kind| kind.unit(0));
            joint.origin *= displacement;
            joint.kind = UrdfJointKind::Fixed;
            constant.insert(joint.name.clone(), value);
            let message =
                format!("it mimics joint {:?}, which never moves, so it is held at {value} {unit}", mimic.joint);
            let element = Some(Element::Joint(joint.name.clone()));
            warnings.push(Warning::odd(&robot.path, Some(joint.line), element, message));
        }
        if constant.len() == known {
            break;
        }
    }
    robot.warnings.extend(Warning::of_kind(warnings, "joint", "joints"));
}

/// The position of a follower of a joint that never moves [rad or m], and its displacement.
fn constant_displacement(joint: &UrdfJoint, constant: &HashMap<String, f64>) -> Option<(f64, Pose)> {
    let mimic = joint.mimic.as_ref()?;
    let value = mimic.multiplier * constant.get(&mimic.joint)? + mimic.offset;
    let pose = match joint.kind {
        UrdfJointKind::Prismatic => Pose::from_parts(Translation3::from(joint.axis * value), Rotation3::identity()),
        UrdfJointKind::Revolute | UrdfJointKind::Continuous => {
            let turn = Rotation3::from_axis_angle(&Unit::new_unchecked(joint.axis), value);
            Pose::from_parts(Translation3::identity(), turn)
        }
        _ => return None,
    };
    value.is_finite().then_some((value, pose))
}

#[cfg(test)]
mod tests {
    use crate::model::{Model, ModelOptions};
    use crate::scene::{PackagePath, robot_from_text};
    use nalgebra::Vector3;
    use std::path::Path;

    #[test]
    fn followers_of_a_fixed_joint_stand_at_their_offset_and_their_followers_in_turn() {
        let link = |name: &str| {
            format!(
                "<link name='{name}'><inertial><origin xyz='0 0 -1'/><mass value='1'/>\
                 <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>"
            )
        };
        let joint = |name: &str, kind: &str, parent: &str, child: &str, more: &str| {
            format!("<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{more}</joint>")
        };
        let text = [
            "<robot name='r'><link name='base'/>".to_string(),
            ["arm", "turned", "slid", "welded"].map(link).concat(),
            joint("free", "continuous", "base", "arm", "<axis xyz='0 1 0'/>"),
            joint(
                "turn",
                "continuous",
                "arm",
                "turned",
                "<axis xyz='0 0 1'/><mimic joint='slide' multiplier='2' offset='1'/>",
            ),
            joint(
                "slide",
                "prismatic",
                "turned",
                "slid",
                "<axis xyz='1 0 0'/><mimic joint='weld' multiplier='3' offset='0.25'/>",
            ),
            joint("weld", "fixed", "slid", "welded", ""),
            "</robot>".to_string(),
        ]
        .concat();
        let robot = robot_from_text(&text, Path::new("r.urdf"), &PackagePath::default()).expect("a robot");
        let model = Model::new(robot, &ModelOptions::default()).expect("a model");
        assert_eq!(model.mechanism.bodies.len(), 1);
        let held: Vec<String> =
            model.warnings.iter().map(ToString::to_string).filter(|warning| warning.contains("mimics")).collect();
        let expected = "r.urdf:1: joint \"slide\": it mimics joint \"weld\", which never moves, so it is held at 0.25 m; the same \
                        for 1 more joint";
        assert_eq!(held, [expected]);
        let place = |name: &str| model.links.iter().find(|link| link.name == name).expect("a link").in_body;
        // Twice 0.25 m and 1 rad: 1.5 rad about z, and 0.25 m along the x axis that this turned.
        let in_arm = place("arm").inverse() * place("welded");
        let (sine, cosine) = 1.5_f64.sin_cos();
        assert!((in_arm.translation.vector - Vector3::new(0.25 * cosine, 0.25 * sine, 0.0)).amax() < 1e-15, "{in_arm}");
        assert!((in_arm.rotation * Vector3::x() - Vector3::new(cosine, sine, 0.0)).amax() < 1e-15, "{in_arm}");
    }
}

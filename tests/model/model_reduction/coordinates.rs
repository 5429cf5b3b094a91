//! The coordinates of joints come back as they were given, and a start is where it was asked for; what cannot be is named.

use super::{fixed, floating, joint, link, random_positions, robot, zoo};
use crate::common::Numbers;
use catena::mechanism::description::joint::{JointKind, Pose};
use catena::mechanism::motion::kinematics::body_states;
use catena::model::ModelError;
use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};

#[test]
fn user_coordinates_come_back() {
    let base_pose = Pose::from_parts(Translation3::new(1.0, -2.0, 3.0), Rotation3::from_euler_angles(0.3, -0.4, 2.0));
    let model = floating(&zoo(), base_pose);
    let mut numbers = Numbers::new(11);
    for _ in 0..20 {
        let positions = random_positions(&model, &mut numbers);
        let velocities = random_positions(&model, &mut numbers);
        let state = model.initial_state(&positions, &velocities, None).unwrap();
        for ((name, given), (_, rates)) in positions.iter().zip(&velocities) {
            let joint = model.joint(name).unwrap();
            let (position, velocity) = model.joint_user_coordinates(joint, &state.position, &state.velocity);
            let kind = model.mechanism.bodies[model.joints[joint].body.unwrap()].joint.kind;
            let wanted: Vec<f64> = match kind {
                JointKind::Spherical => quaternion(given).to_vec(),
                JointKind::Floating => [given[..3].to_vec(), quaternion(&given[3..]).to_vec()].concat(),
                _ => given.clone(),
            };
            close(&position, &wanted, 1e-13, name);
            close(&velocity, rates, 1e-13, name);
        }
    }
    // Joints that do not move have no coordinates.
    let weld = model.joints.iter().position(|joint| joint.kind.name() == "fixed").unwrap();
    let state = model.zero_state();
    assert_eq!(model.joint_user_coordinates(weld, &state.position, &state.velocity), (vec![], vec![]));
}

fn quaternion(rpy: &[f64]) -> [f64; 4] {
    let q = UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [sign * q.w, sign * q.i, sign * q.j, sign * q.k]
}

#[track_caller]
fn close(found: &[f64], wanted: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), wanted.len(), "{what}");
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() < tolerance, "{what}: {found} is not {wanted}");
    }
}

#[test]
fn a_floating_base_starts_at_its_pose_with_the_velocity_of_its_origin() {
    let base_pose = Pose::from_parts(Translation3::new(1.0, -2.0, 3.0), Rotation3::from_euler_angles(0.3, -0.4, 2.0));
    let text = robot(&[link("box", 2.0, "0.5 0 0", "0.1 0.2 0.3", [0.1, 0.2, 0.25])]);
    let model = floating(&text, base_pose);
    let state = model.initial_state(&[], &[], Some([1.0, 2.0, 3.0, 0.1, 0.2, 0.3])).unwrap();
    let bodies = body_states(&model.mechanism, &state);
    let (position, rotation) = model.link_pose(&bodies, 0);
    assert!((position - base_pose.translation.vector).amax() < 1e-15);
    assert!((rotation - base_pose.rotation.matrix()).amax() < 1e-15 * 2.0);
    let (linear, angular) = model.link_velocity(&bodies, 0);
    let omega = Vector3::new(0.1, 0.2, 0.3);
    let arm = base_pose.rotation * Vector3::new(0.5, 0.0, 0.0);
    assert!((angular - omega).amax() < 1e-15);
    assert!((linear - (Vector3::new(1.0, 2.0, 3.0) + omega.cross(&arm))).amax() < 1e-14);
    let (_, velocity) = model.joint_user_coordinates(0, &state.position, &state.velocity);
    close(&velocity, &[1.0, 2.0, 3.0, 0.1, 0.2, 0.3], 1e-14, "base");
    assert_eq!(model.joints[0].name, "base");

    let fixed_base = fixed(&robot(&[link("box", 2.0, "0 0 0", "0 0 0", [0.1, 0.2, 0.25])]));
    let refused = fixed_base.initial_state(&[], &[], Some([0.0; 6])).unwrap_err();
    assert_eq!(refused, ModelError::BaseDoesNotFloat);
}

#[test]
fn the_name_of_the_floating_base_is_free() {
    let text = robot(&[
        link("trunk", 2.0, "0 0 0", "0 0 0", [0.1, 0.2, 0.25]),
        link("arm", 2.0, "0 0 1", "0 0 0", [0.1, 0.2, 0.25]),
        joint("base", "continuous", "trunk", "arm", "0 0 0", "0 0 0", "0 1 0"),
    ]);
    let model = floating(&text, Pose::identity());
    let names: Vec<&str> = model.moving_joints().collect();
    assert_eq!(names, ["trunk_floating_base", "base"]);
}

#[test]
fn wrong_initial_conditions_are_named() {
    let model = fixed(&robot(&[
        "<link name=\"base\"/>".to_string(),
        link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]),
        "<link name=\"tip\"/>".to_string(),
        joint("ball", "spherical", "base", "arm", "0 0 0", "0 0 0", "0 1 0"),
        joint("weld", "fixed", "arm", "tip", "0 0 0", "0 0 0", "0 1 0"),
    ]));
    let position = |name: &str, values: &[f64]| model.initial_state(&[(name.to_string(), values.to_vec())], &[], None);
    let velocity = |name: &str, values: &[f64]| model.initial_state(&[], &[(name.to_string(), values.to_vec())], None);
    let text = position("bull", &[0.0]).unwrap_err().to_string();
    assert_eq!(text, "there is no joint \"bull\"; the joints that move are \"ball\"");
    let text = position("weld", &[0.0]).unwrap_err().to_string();
    assert_eq!(text, "joint \"weld\" does not move (it is fixed); the joints that move are \"ball\"");
    let text = position("ball", &[0.0]).unwrap_err().to_string();
    assert_eq!(text, "the position of spherical joint \"ball\" needs 3 numbers (roll,pitch,yaw), not 1");
    let text = velocity("ball", &[0.0; 4]).unwrap_err().to_string();
    assert_eq!(text, "the velocity of spherical joint \"ball\" needs 3 numbers (wx,wy,wz), not 4");
    assert!(matches!(velocity("ball", &[0.0, f64::NAN, 0.0]), Err(ModelError::NotFinite { .. })));
    assert!(position("ball", &[0.1, 0.2, 0.3]).is_ok());
}

#[test]
fn a_continuous_joint_has_no_limits_whatever_its_file_says() {
    let limits = |kind: &str, range: &str| {
        let limit = format!("<limit {range} effort=\"1\" velocity=\"1\"/></joint>");
        let text = robot(&[
            "<link name=\"base\"/>".to_string(),
            link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]),
            joint("hinge", kind, "base", "arm", "0 0 0", "0 0 0", "0 1 0").replace("</joint>", &limit),
        ]);
        let model = fixed(&text);
        let said = model.warnings.iter().filter(|warning| {
            warning.message == "lower and upper limits of 1 continuous joint are not read" && warning.line == Some(4)
        });
        let limits: Vec<_> = model.mechanism.limits.iter().map(|limit| (limit.lower, limit.upper)).collect();
        (limits, said.count())
    };
    let range = "lower=\"-0.5\" upper=\"0.25\"";
    assert_eq!(limits("revolute", range), (vec![(-0.5, 0.25)], 0));
    assert_eq!(limits("continuous", range), (vec![], 1));
    assert_eq!(limits("revolute", "lower=\"-0.5\""), (vec![(-0.5, f64::INFINITY)], 0));
    // What leaves nothing or everything free is no range.
    for nothing in ["", "lower=\"0\" upper=\"0\"", "lower=\"-inf\" upper=\"inf\""] {
        assert_eq!(limits("revolute", nothing), (vec![], 0), "{nothing}");
        assert_eq!(limits("continuous", nothing), (vec![], 0), "{nothing}");
    }
}

#[test]
fn angles_without_digits_are_refused_and_lengths_are_not() {
    let start = |kind: &str, values: &[f64]| {
        let text = robot(&[
            "<link name=\"base\"/>".to_string(),
            link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]),
            joint("shoulder", kind, "base", "arm", "0 0 0", "0 0 0", "0 1 0"),
        ]);
        fixed(&text).initial_state(&[("shoulder".to_string(), values.to_vec())], &[], None)
    };
    let refused = start("continuous", &[-1e300]).unwrap_err().to_string();
    assert!(refused.starts_with("the position of joint \"shoulder\" is -1e300 rad"), "{refused}");
    for (kind, values) in [("revolute", &[1.01e8][..]), ("planar", &[0.0, 0.0, 1.01e8])] {
        assert!(matches!(start(kind, values), Err(ModelError::TurnedTooOften { .. })), "{kind}");
    }
    assert_eq!(start("continuous", &[1e8]).unwrap().position, [1e8]);
    assert_eq!(start("prismatic", &[1e9]).unwrap().position, [1e9]);
    assert_eq!(start("planar", &[1e9, -1e9, 1.0]).unwrap().position, [1e9, -1e9, 1.0]);
    assert!(start("spherical", &[1e300, 0.0, 0.0]).is_ok());
}

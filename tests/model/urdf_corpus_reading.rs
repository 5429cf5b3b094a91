//! Real URDFs: those that work elsewhere load with the bodies they should have; damaged ones load with a warning or
//! give one clear error.

use crate::common::{Numbers, literal_link_poses, rotation_angle, shared};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::motion::kinematics::body_states;
use catena::model::{Base, Model, ModelError, ModelOptions};
use catena::scene::{PackagePath, Robot, SceneError, read_urdf, robot_from_text};
use std::path::{Path, PathBuf};

/// Links, joints and bodies that move (fixed base) of the robots that must load.
const LOADS: [(&str, usize, usize, usize); 22] = [
    ("acrobot_drake", 3, 3, 2),
    ("anymal_b", 23, 22, 12),
    ("baxter", 57, 56, 19),
    ("cartpole", 3, 2, 2),
    ("double_pendulum", 3, 2, 2),
    ("humanoid_pybullet", 16, 15, 12),
    ("hyq", 19, 18, 12),
    ("iiwa_pybullet", 8, 7, 7),
    ("kinova", 13, 12, 6),
    ("laikago", 21, 20, 12),
    ("mini_cheetah", 17, 16, 12),
    ("minitaur", 27, 26, 16),
    ("panda", 13, 12, 9),
    ("pendulum5", 6, 5, 5),
    ("pendulum_drake", 4, 3, 1),
    ("r2d2", 16, 15, 8),
    ("romeo_small", 58, 57, 31),
    ("simple_humanoid", 31, 30, 29),
    ("so100", 7, 6, 6),
    ("solo12", 17, 16, 12),
    ("talos_reduced", 60, 59, 32),
    ("ur5", 11, 10, 6),
];

fn read(path: &Path) -> Result<Robot, SceneError> {
    read_urdf(path, &PackagePath::default())
}

fn urdf_files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn every_robot_that_must_load_has_the_expected_bodies() {
    let Some(folder) = shared("urdf-corpus/loads") else { return };
    assert_eq!(urdf_files(&folder).len(), LOADS.len(), "every file is listed");
    for (name, links, joints, bodies) in LOADS {
        let robot = read(&folder.join(format!("{name}.urdf"))).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((robot.links.len(), robot.joints.len()), (links, joints), "{name}");
        let model = Model::new(robot, &ModelOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(model.mechanism.bodies.len(), bodies, "{name}");
        assert_eq!(model.links.len(), links, "{name}");
    }
}

#[test]
fn every_warning_names_the_file_and_a_line() {
    let Some(folder) = shared("urdf-corpus") else { return };
    for path in urdf_files(&folder.join("loads")).iter().chain(&urdf_files(&folder.join("rejects"))) {
        let Ok(robot) = read(path) else { continue };
        for warning in &robot.warnings {
            assert!(warning.line.is_some(), "{warning}");
            assert!(warning.to_string().starts_with(&path.display().to_string()), "{warning}");
            assert!(!warning.to_string().contains('\n'), "{warning}");
        }
    }
}

#[test]
fn every_link_of_every_robot_is_where_its_urdf_puts_it() {
    let Some(folder) = shared("urdf-corpus/loads") else { return };
    let mut numbers = Numbers::new(5);
    for (name, ..) in LOADS {
        let model = Model::new(read(&folder.join(format!("{name}.urdf"))).unwrap(), &ModelOptions::default()).unwrap();
        for _ in 0..5 {
            let positions: Vec<(String, Vec<f64>)> = model
                .mechanism
                .bodies
                .iter()
                .map(|body| {
                    let values = (0..body.joint.kind.velocity_count()).map(|_| numbers.next(-1.5, 1.5)).collect();
                    (body.joint.name.clone(), values)
                })
                .collect();
            let bodies = body_states(&model.mechanism, &model.initial_state(&positions, &[], None).unwrap());
            for (index, literal) in
                literal_link_poses(&model.robots[0].robot, &Pose::identity(), &positions).iter().enumerate()
            {
                let (position, rotation) = model.link_pose(&bodies, index);
                let link = &model.links[index].name;
                let distance = (position - literal.translation.vector).norm();
                assert!(distance < 1e-13, "{name} {link}: {distance:e} m");
                let angle = rotation_angle(&rotation, literal.rotation.matrix());
                assert!(angle < 1e-13, "{name} {link}: {angle:e} rad");
            }
        }
    }
}

#[test]
fn robots_with_a_root_link_of_their_own_float() {
    let Some(folder) = shared("urdf-corpus/loads") else { return };
    // Attached to the world by their URDF; and one whose root has no mass.
    let attached = ["acrobot_drake", "pendulum5", "pendulum_drake", "ur5"];
    for (name, _, _, bodies) in LOADS {
        let robot = read(&folder.join(format!("{name}.urdf"))).unwrap();
        match Model::new(robot, &ModelOptions { base: Base::Floating, ..Default::default() }) {
            Ok(model) => assert_eq!(model.mechanism.bodies.len(), bodies + 1, "{name}"),
            Err(ModelError::BaseIsWorld { .. }) => assert!(attached.contains(&name), "{name}"),
            Err(ModelError::NoInertia { .. }) => assert_eq!(name, "cartpole"),
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn damaged_files_load_with_a_warning_or_give_one_clear_error() {
    let Some(folder) = shared("urdf-corpus/rejects") else { return };
    // What the message must contain; `Err` where the intent is not plain.
    let expected: [(&str, Result<&str, &str>); 11] = [
        ("bad_float", Err("bad_float.urdf:115: joint \"torso_to_rightleg\": <limit lower=\"-1.57.\">")),
        ("bike_commas", Ok("bike_commas.urdf:103: joint \"handlebar_to_frontwheel\": <origin xyz=\"0.07, 0, -0.69\">")),
        ("cdf_geometry", Ok("cdf_geometry.urdf:22: link \"base_link\": its <collision> was left out: <cdf>")),
        ("duplicate_axis", Ok("duplicate_axis.urdf:550: joint \"RL_lower_joint\": <axis> is given twice")),
        ("four_numbers", Err("four_numbers.urdf:16: link \"chassis\": <mesh scale=\"1 1 1 1\">: 3 numbers")),
        ("husky_xacro_leftover", Err("husky_xacro_leftover.urdf:97: joint \"imu_joint\": <origin")),
        ("icub_mesh_without_filename", Ok("ignored: <texture> of <material> (28 times)")),
        ("microtaur_rpy4", Err("microtaur_rpy4.urdf:300: joint \"dynamixel7_chassis_left\": <origin rpy=")),
        ("plane_geometry", Ok("plane_geometry.urdf:21: link \"planeLink\": its <collision> was left out: <plane>")),
        ("racecar_xacro", Ok("racecar_xacro.urdf:284: ignored: <material> of <geometry>")),
        ("spherical_limit_no_velocity", Ok("velocity.urdf:30: joint \"neck\": <limit> has no velocity")),
    ];
    assert_eq!(urdf_files(&folder).len(), expected.len(), "every file is listed");
    for (name, expected) in expected {
        match (read(&folder.join(format!("{name}.urdf"))), expected) {
            (Ok(robot), Ok(part)) => {
                let warnings: Vec<String> = robot.warnings.iter().map(ToString::to_string).collect();
                assert!(warnings.iter().any(|warning| warning.contains(part)), "{part:?} in {warnings:#?}");
                Model::new(robot, &ModelOptions::default()).unwrap_or_else(|error| panic!("{error}"));
            }
            (Err(error), Err(part)) => {
                let text = error.to_string();
                assert!(text.contains(part) && !text.contains('\n'), "{part:?} in {text}");
            }
            (Ok(_), Err(part)) => panic!("{name} must be refused: {part}"),
            (Err(error), Ok(_)) => panic!("{name} must load: {error}"),
        }
    }
}

#[test]
fn no_damage_to_a_real_robot_makes_reading_or_reduction_panic() {
    let Some(folder) = shared("urdf-corpus") else { return };
    let mut numbers = Numbers::new(9);
    let pieces = [
        "",
        "<",
        ">",
        "\"",
        "-",
        "1e308",
        "-1e308",
        "0",
        "nan",
        "<link name=\"x\"/>",
        "</joint>",
        "fixed",
        "\u{0}",
        "é",
    ];
    let (mut read, mut modelled) = (0, 0);
    for path in urdf_files(&folder.join("loads")).iter().chain(&urdf_files(&folder.join("rejects"))) {
        let text = std::fs::read_to_string(path).unwrap();
        for _ in 0..60 {
            let mut damaged = text.clone();
            // Half of the time a whole number is replaced: such files often stay readable.
            let start = numbers.next(0.0, text.len() as f64) as usize;
            let start = match damaged.get(start..).and_then(|rest| rest.find("=\"")) {
                Some(offset) if numbers.next(0.0, 1.0) < 0.5 => start + offset + 2,
                _ => start,
            };
            let is_end = |c: char| c == '"' || c == ' ' || c == '\n';
            let Some(length) = damaged.get(start..).and_then(|rest| rest.find(is_end)) else { continue };
            damaged.replace_range(start..start + length, pieces[numbers.next(0.0, pieces.len() as f64) as usize]);
            let Ok(robot) = robot_from_text(&damaged, path, &PackagePath::default()) else { continue };
            read += 1;
            for base in [Base::Fixed, Base::Floating] {
                let model = Model::new(robot.clone(), &ModelOptions { base, ..Default::default() });
                modelled +=
                    usize::from(model.is_ok_and(|model| model.zero_state().position.iter().all(|q| q.is_finite())));
            }
        }
    }
    assert!(read > 200 && modelled > 200, "the damage must not hide everything: {read}, {modelled}");
}

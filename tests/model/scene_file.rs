//! Claims about scene files: what they may say, what they may not, and where the command line has the last word.

use crate::common::command::{self, assert_one_error, run};
use catena::closures::loop_gaps;
use catena::kinematics::body_states;
use catena::model::{LoopKind, Model, Start};
use catena::rest::is_at_rest;
use catena::scene::{PackagePath, Scene, SceneError, read_urdf, scene_from_text};
use catena::state::State;
use nalgebra::Vector3;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Two rods one below the other, a point mass fixed to the second, and a leaf without mass.
const DOUBLE: &str = r#"<robot name="double">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.5" rpy="0.3 0.2 0.1"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="weight"><inertial><mass value="2"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="sensor"/>
  <link name="lens"/>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0 0 -1"/><axis xyz="0 1 0"/></joint>
  <joint name="weld" type="fixed"><parent link="lower"/><child link="weight"/><origin xyz="0.1 0 -1" rpy="0 0 0.5"/></joint>
  <joint name="tilt" type="continuous"><parent link="lower"/><child link="sensor"/><axis xyz="0 1 0"/></joint>
  <joint name="mount" type="fixed"><parent link="sensor"/><child link="lens"/></joint>
</robot>"#;

const BALL: &str = r#"<robot name="ball">
  <link name="ball"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"#;

/// A folder with the robots in it.
fn folder(name: &str) -> PathBuf {
    let folder = command::folder(name);
    for (file, text) in [("double.urdf", DOUBLE), ("ball.urdf", BALL)] {
        std::fs::write(folder.join(file), text).expect("written");
    }
    folder
}

fn read(folder: &Path, text: &str) -> Result<Scene, SceneError> {
    scene_from_text(text, &folder.join("scene.toml"), &mut |urdf| read_urdf(urdf, &PackagePath::default()))
}

fn build(folder: &Path, text: &str) -> (Model, Start, State) {
    let scene = read(folder, text).unwrap_or_else(|error| panic!("{error}"));
    let (model, start) = Model::from_scene(&scene).unwrap_or_else(|error| panic!("{error}"));
    let state = model.initial_state(&start.positions, &start.velocities, None).unwrap();
    (model, start, state)
}

/// The largest gap of the first loop.
fn gap(model: &Model, state: &State) -> f64 {
    loop_gaps(&model.mechanism.loops[0], &body_states(&model.mechanism, state)).largest().0
}

/// The message of a scene that cannot be, without the folder.
fn refusal(folder: &Path, text: &str) -> String {
    let message = match read(folder, text) {
        Err(error) => error.to_string(),
        Ok(scene) => match Model::from_scene(&scene) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("accepted:\n{text}"),
        },
    };
    message.replace(&format!("{}/", folder.display()), "")
}

const ONE: &str = "[[robot]]\nurdf = \"double.urdf\"\n";

/// Two robots, on six lines.
const TWO: &str =
    "[[robot]]\nname = \"left\"\nurdf = \"pendulum.urdf\"\n[[robot]]\nname = \"right\"\nurdf = \"pendulum.urdf\"\n";

#[test]
fn what_is_wrong_is_said_with_file_line_and_key() {
    let folder = folder("errors");
    let ends = |a: &str, b: &str| format!("a = {{ {a} }}\nb = {{ {b} }}\n");
    let both = ends("link = \"lower\", axis = [0, 1, 0]", "link = \"world\", axis = [0, 1, 0]");
    let closing = |kind: &str, rest: &str| format!("{ONE}[[loop]]\nname = \"c\"\ntype = \"{kind}\"\n{rest}");
    // Lines 1 and 2 are the robot in most of them.
    let cases: Vec<(String, &[&str])> = vec![
        (String::new(), &["scene.toml:1: ", "no [[robot]]"]),
        ("[scene]\nname = \"x".into(), &["scene.toml:2: "]),
        ("[robot]\nurdf = \"double.urdf\"".into(), &["scene.toml:1: robot: ", "write [[robot]]"]),
        (format!("{ONE}bas = \"fixed\""), &["scene.toml:3: robot.bas: unknown field", "`base`"]),
        (format!("{ONE}[scen]\n"), &["scene.toml:3: scen: unknown field"]),
        (format!("{ONE}[simulation]\nsteps = 3"), &["scene.toml:4: simulation.steps: unknown field"]),
        (format!("{ONE}pose = {{ positon = [0, 0, 0] }}"), &["scene.toml:3: robot.pose.positon: unknown field"]),
        (format!("{ONE}pose = {{ position = [0, 0] }}"), &["scene.toml:3: robot.pose.position: ", "length 2"]),
        (
            format!("{ONE}pose = {{ position = [0, nan, 0] }}"),
            &["scene.toml:3: robot.pose.position: NaN is not finite"],
        ),
        (format!("{ONE}positions = {{ elbow = inf }}"), &["scene.toml:3: robot.positions.elbow: inf is not finite"]),
        (format!("{ONE}positions = {{ elbow = \"up\" }}"), &["scene.toml:3: robot.positions.elbow: "]),
        (format!("{ONE}positions = {{ knee = 1 }}"), &["scene.toml:3: ", "no joint \"knee\"", "\"elbow\""]),
        (format!("{ONE}\npositions = {{ elbow = [1, 2] }}"), &["scene.toml:4: ", "\"elbow\" needs one number"]),
        (format!("{ONE}velocities = {{ tilt = 1 }}"), &["scene.toml:3: ", "\"tilt\" does not move"]),
        (format!("{ONE}base = \"flying\""), &["scene.toml:3: robot.base: ", "`fixed` or `floating`"]),
        (format!("{ONE}velocity = {{ linear = [1, 0, 0] }}"), &["scene.toml:3: robot \"double\": ", "floating"]),
        ("[[robot]]\nname = \"a\"".into(), &["scene.toml:1: robot: missing field `urdf`"]),
        ("[[robot]]\nurdf = \"none.urdf\"".into(), &["scene.toml:2: robot.urdf: ", "none.urdf"]),
        ("[[robot]]\nurdf = \"ball.urdf\"\nname = \"a/b\"".into(), &["scene.toml:3: robot \"a/b\": "]),
        (format!("{ONE}{ONE}"), &["scene.toml:3: robot \"double\": ", "taken on line 1"]),
        (format!("{ONE}[[motor]]\njoint = \"elbow\""), &["scene.toml:3: ", "[[motor]] is not simulated yet"]),
        (format!("{ONE}[[obstacle]]\n"), &["scene.toml:3: ", "[[obstacle]] is not simulated yet"]),
        (format!("{ONE}\n[contact]\npairs = \"all\""), &["scene.toml:4: ", "[contact] is not simulated yet"]),
        (format!("{ONE}[simulation]\nduration = 0"), &["scene.toml:4: simulation.duration: 0 must be greater"]),
        (format!("{ONE}[simulation]\nstages = 3"), &["scene.toml:4: ", "needs a step"]),
        (format!("{ONE}[simulation]\nstep = 0.1"), &["scene.toml:4: ", "needs stages"]),
        (format!("{ONE}[simulation]\nstages = 17\nstep = 0.1"), &["scene.toml:4: ", "2 to 16"]),
        (
            format!("{ONE}[simulation]\nstages = 3\nstep = 0.1\ntolerance = 1e-3"),
            &["scene.toml:6: ", "either tolerance, or stages and step"],
        ),
        (format!("{ONE}[simulation]\nrate = 1e7"), &["scene.toml:4: ", "at most 1e6"]),
        (closing("hinge", &both), &["scene.toml:5: loop.type: unknown variant `hinge`", "`revolute`"]),
        (closing("revolute", &both.replace("lower", "knee")), &["scene.toml:6: loop \"c\": ", "no link \"knee\""]),
        (
            closing("revolute", &both.replacen("[0, 1, 0]", "[0, 0, 0]", 1)),
            &["scene.toml:6: loop \"c\": the axis is zero"],
        ),
        (
            closing("revolute", &both.replacen(", axis = [0, 1, 0]", "", 1)),
            &["scene.toml:6: loop \"c\": ", "need an axis"],
        ),
        (closing("fixed", &both.replacen(", axis = [0, 1, 0]", "", 1)), &["scene.toml:3: loop \"c\": ", "at none"]),
        (closing("revolute", &format!("{both}length = 1")), &["scene.toml:8: loop \"c\": ", "\"distance\""]),
        (closing("spherical", "a = { link = \"lower\" }"), &["scene.toml:3: loop: missing field `b`"]),
        (
            format!("{}[[loop]]\nname = \"c\"\ntype = \"planar\"\n{both}", closing("planar", &both)),
            &["scene.toml:8: loop \"c\": ", "taken on line 3"],
        ),
        (
            closing("spherical", &ends("link = \"lower\"", "link = \"lower\"")),
            &["scene.toml:3: loop \"c\": ", "says nothing new"],
        ),
        (
            closing("spherical", &ends("link = \"lower\"", "link = \"weight\"")),
            &["scene.toml:3: loop \"c\": ", "\"lower\" and \"weight\" are fixed to each other and 1.00e0 m"],
        ),
        (
            closing("spherical", &ends("link = \"base\"", "link = \"world\"")),
            &["scene.toml:3: loop \"c\": ", "says nothing new"],
        ),
        (
            closing("spherical", &ends("link = \"upper\", position = [0, 0, -1]", "link = \"lower\"")),
            &["scene.toml:3: loop \"c\": ", "whatever they do"],
        ),
        (
            closing("spherical", &ends("link = \"lower\", position = [1e200, 0, 0]", "link = \"world\"")),
            &["scene.toml:3: loop \"c\": ", "\"lower\" is so far away"],
        ),
        (
            closing("spherical", &ends("link = \"lens\"", "link = \"world\"")),
            &["scene.toml:3: loop \"c\": ", "\"lens\" is not simulated"],
        ),
        (
            closing(
                "distance",
                &ends("link = \"lower\", position = [0, 0, -1]", "link = \"world\", position = [0, 0, -2]"),
            ),
            &["scene.toml:3: loop \"c\": ", "no distance"],
        ),
        (
            format!("{ONE}[[spring]]\njoint = \"elbow\"\nrest_length = 1"),
            &["scene.toml:5: spring \"spring1\": ", "no rest_length"],
        ),
        (
            format!("{ONE}[[spring]]\njoint = \"elbow\"\nrest = 1"),
            &["scene.toml:3: spring \"spring1\": ", "needs its stiffness, its damping, or both"],
        ),
        (format!("{ONE}[[spring]]\nstiffness = 1"), &["scene.toml:3: spring \"spring1\": ", "either between points"]),
        (
            format!("{ONE}[[spring]]\njoint = \"elbow\"\nstiffness = -1"),
            &["scene.toml:5: spring.stiffness: -1 must not be negative"],
        ),
        (
            format!("{ONE}[[spring]]\nstiffness = 1\n{}", ends("link = \"lower\"", "link = \"world\"")),
            &["scene.toml:3: spring \"spring1\": ", "needs its rest_length"],
        ),
        (
            format!(
                "{ONE}[[spring]]\nstiffness = 1\nrest_length = 1\n{}",
                ends("link = \"lower\"", "link = \"weight\"")
            ),
            &["scene.toml:3: spring \"spring1\": ", "does nothing"],
        ),
        (format!("{ONE}[[load]]\njoint = \"weld\"\neffort = 1"), &["scene.toml:3: load on \"weld\": ", "is fixed"]),
        (format!("{ONE}[[load]]\njoint = \"elbow\""), &["scene.toml:3: ", "needs its effort"]),
        (
            format!("{ONE}[[load]]\nlink = \"base\"\nforce = [1, 0, 0]"),
            &["scene.toml:3: load on \"base\": ", "fixed in the world"],
        ),
        (format!("{ONE}[[load]]\nlink = \"lower\""), &["scene.toml:3: ", "needs a force or a torque"]),
        (format!("{ONE}[[load]]\neffort = 1"), &["scene.toml:3: ", "either on a joint or on a link"]),
        (
            format!("{TWO}[[load]]\njoint = \"hinge\"\neffort = 1"),
            &["scene.toml:8: ", "no joint \"hinge\"", "robot/name"],
        ),
    ];
    for (text, parts) in cases {
        let message = refusal(&folder, &text);
        assert!(message.lines().count() == 1, "{message}");
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?} of\n{text}");
        }
    }
}

#[test]
fn several_robots_stand_side_by_side_under_their_own_names() {
    let folder = folder("several");
    let text = "[[robot]]\nname = \"left\"\nurdf = \"double.urdf\"\npositions = { elbow = 0.5 }\n\
                [[robot]]\nname = \"ball\"\nurdf = \"ball.urdf\"\nbase = \"floating\"\n\
                pose = { position = [1, 2, 3], rpy = [0, 0, 1] }\nvelocity = { linear = [0, 0, 1], angular = [0, 0, 2] }\n\
                [[robot]]\nname = \"right\"\nurdf = \"double.urdf\"\npose = { position = [0, 1, 0] }\nvelocities = { elbow = 3 }";
    let (model, _, state) = build(&folder, text);
    let mechanism = &model.mechanism;
    let names: Vec<&str> = mechanism.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["left/upper", "left/lower", "ball/ball", "right/upper", "right/lower"]);
    let parents: Vec<Option<usize>> = mechanism.bodies.iter().map(|body| body.parent).collect();
    assert_eq!(parents, [None, Some(0), None, None, Some(3)]);
    let moving: Vec<&str> = model.moving_joints().collect();
    assert_eq!(moving, ["left/shoulder", "left/elbow", "ball/base", "right/shoulder", "right/elbow"]);
    assert_eq!(model.link("right/weight").map(|link| model.links[link].body), Some(Some(4)));
    let base = &model.joints[model.joint("ball/base").unwrap()];
    assert_eq!((base.parent_link.as_str(), base.child_link.as_str(), base.robot), ("world", "ball/ball", 1));

    let bodies = body_states(mechanism, &state);
    let (place, _) = model.link_pose(&bodies, model.link("ball/ball").unwrap());
    assert!((place - Vector3::new(1.0, 2.0, 3.0)).amax() < 1e-15);
    // The centre of mass, 0.1 m off the origin, moves with both velocities.
    let (velocity, turn) = model.link_velocity(&bodies, model.link("ball/ball").unwrap());
    assert!((velocity - Vector3::new(-0.2 * 1.0_f64.sin(), 0.2 * 1.0_f64.cos(), 1.0)).amax() < 1e-15, "{velocity}");
    assert!((turn - Vector3::new(0.0, 0.0, 2.0)).amax() < 1e-15);
    let joint = |name: &str| model.joint_user_coordinates(model.joint(name).unwrap(), &state.position, &state.velocity);
    assert_eq!(joint("left/elbow"), (vec![0.5], vec![0.0]));
    assert_eq!(joint("right/elbow"), (vec![0.0], vec![3.0]));
    // Both files of the same robot say the same, once.
    let dropped = model.warnings.iter().filter(|warning| warning.message.contains("has mass")).count();
    assert_eq!(dropped, 1);
}

#[test]
fn a_scene_of_one_robot_moves_as_the_robot_alone() {
    let folder = folder("alone");
    let text = "[scene]\ngravity = [0, 0, -1.62]\n[[robot]]\nname = \"x\"\nurdf = \"double.urdf\"\npositions = { elbow = 0.5 }";
    std::fs::write(folder.join("scene.toml"), text).unwrap();
    let links = |arguments: &[&str]| {
        let report = report(&folder, arguments);
        (report["links"].clone(), report["joints"].clone(), report["energy"].clone())
    };
    let method = ["--stages", "3", "--step", "0.01", "--duration", "1", "--no-log", "--json"];
    let of_scene = links(&[&["simulate", "scene.toml"], &method[..]].concat());
    let of_robot = links(
        &[&["simulate", "double.urdf", "--gravity", "0,0,-1.62", "--position", "elbow=0.5"], &method[..]].concat(),
    );
    assert_eq!(of_scene, of_robot);
}

#[test]
fn loops_springs_and_loads_find_links_that_are_fused_into_bodies_or_the_world() {
    let folder = folder("fused");
    let text = "[[robot]]\nname = \"arm\"\nurdf = \"double.urdf\"\npositions = { shoulder = 0.7, elbow = -0.4 }\n\
                [[loop]]\ntype = \"spherical\"\na = { link = \"weight\", position = [0.1, 0.2, 0.3] }\nb = { link = \"base\", position = [1, 2, 3] }\n\
                [[spring]]\na = { link = \"arm/weight\" }\nb = { link = \"upper\" }\nstiffness = 5\nrest_length = 0.1\n\
                [[load]]\nlink = \"weight\"\nposition = [0.1, 0, 0]\nforce = [1, 2, 3]\n\
                [[load]]\njoint = \"arm/elbow\"\neffort = 4\n\
                [[spring]]\njoint = \"elbow\"\nstiffness = 6\ndamping = 7\nrest = 8";
    let (model, _, state) = build(&folder, text);
    let bodies = body_states(&model.mechanism, &state);
    let frame = |link: &str| model.link_pose(&bodies, model.link(link).unwrap());
    let at = |link: &str, point: [f64; 3]| {
        let (place, axes) = frame(link);
        place + axes * Vector3::from(point)
    };
    let [closing] = &model.mechanism.loops[..] else { panic!("one loop") };
    assert_eq!((closing.name.as_str(), closing.kind), ("loop1", LoopKind::Spherical));
    assert_eq!((closing.a.body, closing.b.body), (Some(1), None));
    // Frames go through the principal axes of the bodies, which are turned: a rounding or two at a distance of 2 m.
    assert!((closing.a.place(&bodies).0 - at("weight", [0.1, 0.2, 0.3])).amax() < 1e-15);
    assert!((closing.b.place(&bodies).0 - Vector3::new(1.0, 2.0, 3.0)).amax() == 0.0);
    let forces = &model.mechanism.forces;
    assert!((forces.point_springs[0].a.place(&bodies).0 - at("weight", [0.0; 3])).amax() < 1e-15);
    assert!((forces.point_springs[0].b.place(&bodies).0 - at("upper", [0.0; 3])).amax() < 1e-15);
    let wrench = &forces.wrenches[0];
    let point = bodies[wrench.body].position + bodies[wrench.body].rotation * wrench.point;
    assert!((point - at("weight", [0.1, 0.0, 0.0])).amax() < 1e-15);
    assert_eq!(wrench.force, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!((forces.joint_loads[0].freedom, forces.joint_loads[0].effort), (1, 4.0));
    let spring = &forces.joint_springs[0];
    assert_eq!((spring.coordinate.freedom, spring.stiffness, spring.rest), (1, 6.0, 8.0));
    assert_eq!((forces.joint_dampers[0].freedom, forces.joint_dampers[0].coefficient), (1, 7.0));
}

#[test]
fn loops_that_keep_an_orientation_take_it_from_the_start_of_the_file() {
    let folder = folder("orientation");
    let text = |kind: &str, axes: bool| {
        let axis = if axes { ", axis = [0, 1, 0]" } else { "" };
        // The tip of the lower rod is at (sin, 0, cos)-wise somewhere; the loop's point in the world is put there below.
        format!(
            "{ONE}positions = {{ shoulder = 0.7, elbow = -0.4 }}\n[[loop]]\ntype = \"{kind}\"\n\
             a = {{ link = \"lower\"{axis} }}\nb = {{ link = \"world\", position = [-0.644217687237691, 0, -0.764842187284489]{axis} }}"
        )
    };
    for (kind, axes) in [("prismatic", true), ("fixed", true), ("fixed", false)] {
        let (model, _, state) = build(&folder, &text(kind, axes));
        let gap = gap(&model, &state);
        assert!(gap < 1e-14, "{kind} {axes}: {gap:e}");
    }
    // And a rod without a length is as long as its ends are apart.
    let (model, _, state) = build(&folder, &text("distance", false).replace("-0.764842187284489", "2"));
    let LoopKind::Distance(length) = model.mechanism.loops[0].kind else { panic!("a distance") };
    assert!((length - 2.764842187284489).abs() < 1e-14, "{length}");
    assert!(gap(&model, &state) < 1e-15);
    let longer = text("distance", false) + "\nlength = 1.5";
    assert_eq!(build(&folder, &longer).0.mechanism.loops[0].kind, LoopKind::Distance(1.5));
}

#[test]
fn an_axis_that_is_not_of_length_one_is_normalised_with_a_warning() {
    let folder = folder("axis");
    let text = format!(
        "{ONE}[[loop]]\ntype = \"cylindrical\"\na = {{ link = \"lower\", axis = [0, 3, 4] }}\n\
         b = {{ link = \"world\", axis = [0, 0.6, 0.8] }}"
    );
    let (model, _, _) = build(&folder, &text);
    let warnings: Vec<String> = model.warnings.iter().map(ToString::to_string).collect();
    let axis: Vec<&String> = warnings.iter().filter(|warning| warning.contains("has length")).collect();
    assert!(axis.len() == 1 && axis[0].contains("scene.toml:5: loop \"loop1\": the axis has length 5"), "{warnings:?}");
    let z = model.mechanism.loops[0].b.frame.rotation.matrix().column(2).into_owned();
    assert!((z - Vector3::new(0.0, 0.6, 0.8)).amax() < 1e-15);
}

#[test]
fn loop_joints_of_a_urdf_close_loops() {
    let folder = folder("loop_joint");
    // As Dojo and RigidBodyDynamics.jl write it: the axis in the frames of both ends.
    let closing = r#"<loop_joint name="closure" type="continuous"><axis xyz="0 1 0"/>
      <link1 link="weight" rpy="0 0 -0.5" xyz="0 0 0"/><link2 link="base" xyz="0.1 0 -2"/><dynamics damping="1"/></loop_joint>"#;
    let urdf = DOUBLE.replace("</robot>", &format!("{closing}</robot>"));
    std::fs::write(folder.join("closed.urdf"), &urdf).unwrap();
    let (model, _, state) = build(&folder, "[[robot]]\nurdf = \"closed.urdf\"");
    let [closed] = &model.mechanism.loops[..] else { panic!("one loop") };
    assert_eq!((closed.name.as_str(), closed.kind), ("closure", LoopKind::Revolute));
    assert!(gap(&model, &state) < 1e-15);
    assert!(model.warnings.iter().any(|warning| warning.message.contains("damping of a joint that closes a loop")));
    // Viewers get the tree.
    assert!(!model.robots[0].robot.description.contains("loop_joint"));

    for (wrong, right, message) in [
        ("type=\"continuous\"><axis", "type=\"free\"><axis", "type \"free\" is not one of revolute"),
        ("link=\"weight\"", "link=\"wait\"", "its link1 link \"wait\" does not exist"),
        ("<link2 link=\"base\" xyz=\"0.1 0 -2\"/>", "", "<loop_joint> has no <link2>"),
        ("<axis xyz=\"0 1 0\"/>\n", "<axis xyz=\"0 0 0\"/>\n", "the axis is zero"),
    ] {
        std::fs::write(folder.join("closed.urdf"), urdf.replace(wrong, right)).unwrap();
        let refused = refusal(&folder, "[[robot]]\nurdf = \"closed.urdf\"");
        assert!(refused.contains(message) && refused.contains("closed.urdf:1"), "{refused}");
        assert!(refused.contains("loop \"closure\""), "{refused}");
    }
}

#[test]
fn loop_joints_end_at_the_same_world_as_the_joints_of_the_tree() {
    let folder = folder("loop_joint_to_world");
    let closing = r#"<loop_joint name="closure" type="continuous"><axis xyz="0 1 0"/>
      <link1 link="weight" rpy="0 0 -0.5"/><link2 link="world" xyz="0.1 0 -2"/></loop_joint></robot>"#;
    let declared = DOUBLE.replace("\"base\"", "\"world\"").replace("</robot>", closing);
    let undeclared = declared.replace("<link name=\"world\"/>", "");
    for urdf in [declared, undeclared] {
        std::fs::write(folder.join("closed.urdf"), urdf).unwrap();
        let pose = "pose = { position = [0.5, 0.2, 1], rpy = [0.3, 0.2, 0.1] }";
        let (model, _, state) = build(&folder, &format!("[[robot]]\nurdf = \"closed.urdf\"\n{pose}\n"));
        let gap = gap(&model, &state);
        assert!(gap < 1e-15, "{gap}");
    }
}

fn report(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn the_command_line_goes_before_the_scene_file_and_that_before_the_defaults() {
    let folder = folder("overrides");
    let text = "[scene]\nname = \"swing\"\ngravity = [0, 0, -2]\n[[robot]]\nurdf = \"pendulum.urdf\"\n\
                positions = { hinge = 0.5 }\nvelocities = { hinge = 0.25 }\n\
                [simulation]\nduration = 0.5\nstages = 3\nstep = 0.0625\nrate = 10\n";
    std::fs::write(folder.join("scene.toml"), text).unwrap();
    let quick = |extra: &[&str]| report(&folder, &[&["simulate", "scene.toml", "--no-log", "--json"], extra].concat());
    let plain = quick(&[]);
    assert_eq!((&plain["scene"], &plain["duration"]), (&Value::from("swing"), &Value::from(0.5)));
    assert_eq!((&plain["method"]["stages"], &plain["method"]["step"]), (&Value::from(3), &Value::from(0.0625)));
    let start = |report: &Value| report["energy"]["initial"].as_f64().unwrap();
    // Of the rod: m l² about the hinge, and its centre 0.5 m below.
    let energy = |angle: f64, rate: f64, gravity: f64| 0.5 * (0.1 + 0.25) * rate * rate - 0.5 * gravity * angle.cos();
    assert!((start(&plain) - energy(0.5, 0.25, 2.0)).abs() < 1e-14);
    assert!((start(&quick(&["--gravity", "0,0,-3"])) - energy(0.5, 0.25, 3.0)).abs() < 1e-14);
    assert!((start(&quick(&["--position", "hinge=1"])) - energy(1.0, 0.25, 2.0)).abs() < 1e-14);
    assert!((start(&quick(&["--velocity", "hinge=1"])) - energy(0.5, 1.0, 2.0)).abs() < 1e-14);
    assert_eq!(quick(&["--duration", "0.25"])["duration"], 0.25);
    let tolerance = quick(&["--tolerance", "1e-3"]);
    assert_eq!(
        (&tolerance["method"]["adaptive"], &tolerance["method"]["tolerance"]),
        (&Value::from(true), &Value::from(1e-3))
    );
    let fixed = quick(&["--stages", "4", "--step", "0.125"]);
    assert_eq!((&fixed["method"]["stages"], &fixed["method"]["step"]), (&Value::from(4), &Value::from(0.125)));
    let moved = quick(&["--base-pose", "1,2,3,0,0,0"]);
    assert_eq!(moved["links"]["base"]["position"], serde_json::json!([1.0, 2.0, 3.0]));
}

#[test]
fn a_spring_whose_ends_coincide_at_the_start_is_refused_and_is_not_at_rest() {
    let folder = folder("undirected");
    let text = "[[robot]]\nurdf = \"pendulum.urdf\"\n[[spring]]\nstiffness = 5\nrest_length = 1\n\
                a = { link = \"rod\", position = [0, 0, -1] }\nb = { link = \"world\", position = [0, 0, -1] }";
    std::fs::write(folder.join("coincide.toml"), text).unwrap();
    let refused = run(&folder, &["simulate", "coincide.toml", "--no-log"]);
    assert_one_error(&refused, 2, "coincide");
    let message = command::text(&refused.stderr);
    assert!(message.contains("coincide.toml: spring \"spring1\": its ends coincide"), "{message}");
    report(
        &folder,
        &["simulate", "coincide.toml", "--no-log", "--json", "--position", "hinge=0.1", "--duration", "0.1"],
    );
    let (model, _, state) = build(&folder, text);
    assert!(!is_at_rest(&model.mechanism, &state));
    // Without a rest length it is at rest there.
    let (model, _, state) = build(&folder, &text.replace("rest_length = 1", "rest_length = 0"));
    assert!(is_at_rest(&model.mechanism, &state));
}

#[test]
fn one_base_for_several_robots_and_what_is_not_simulated_yet_end_with_2_and_no_file() {
    let folder = folder("refused");
    std::fs::write(folder.join("two.toml"), TWO).unwrap();
    let closing =
        "[[loop]]\ntype = \"distance\"\na = { link = \"left/tip\" }\nb = { link = \"world\", position = [0, 0, 5] }\n";
    std::fs::write(folder.join("closed.toml"), TWO.to_string() + closing).unwrap();
    let before = std::fs::read_dir(&folder).unwrap().count();
    for (arguments, message) in [
        (vec!["simulate", "two.toml", "--base", "floating"], "two.toml has 2"),
        (vec!["simulate", "two.toml", "--base-pose", "0,0,1,0,0,0"], "two.toml has 2"),
        (vec!["simulate", "two.toml", "--base-velocity", "0,0,1,0,0,0"], "floating base"),
        (vec!["simulate", "two.toml", "--position", "hinge=1"], "\"left/hinge\", \"right/hinge\""),
        (
            vec!["chart", "closed.toml", "-o", "charts"],
            "closed.toml: a chart measures against methods in joint coordinates",
        ),
    ] {
        let output = run(&folder, &arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(
            error.starts_with("catena: error: ") && error.contains(message) && error.lines().count() == 1,
            "{error}"
        );
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), before);
}

#[test]
fn the_log_of_several_robots_describes_each_under_its_own_name() {
    let folder = folder("log");
    std::fs::write(folder.join("two.toml"), TWO.to_string() + "[simulation]\nduration = 0.1\n").unwrap();
    report(&folder, &["simulate", "two.toml", "--json", "--stages", "3", "--step", "0.01"]);
    let bytes = std::fs::read(folder.join("two.mcap")).unwrap();
    let messages: Vec<mcap::Message> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    let description = |topic: &str| {
        let message = messages.iter().find(|message| message.channel.topic == topic).expect(topic);
        String::from_utf8_lossy(&message.data).into_owned()
    };
    for robot in ["left", "right"] {
        let urdf = description(&format!("/{robot}/robot_description"));
        for name in [
            format!("<link name=\"{robot}/rod\""),
            format!("<parent link=\"{robot}/base\""),
            format!("<child link=\"{robot}/rod\""),
            format!("<joint name=\"{robot}/hinge\""),
        ] {
            assert!(urdf.contains(&name), "{name} in {urdf}");
        }
    }
    // Its looks are in the frames of the transforms.
    let looks = description("/scene");
    assert!(looks.contains("left/rod") && looks.contains("right/rod"));
    let transforms = description("/tf");
    assert!(transforms.contains("left/rod") && transforms.contains("right/tip"));
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let mut attached: Vec<&str> = summary.attachment_indexes.iter().map(|index| index.name.as_str()).collect();
    attached.sort_unstable();
    assert_eq!(attached, ["left/pendulum.urdf", "right/pendulum.urdf", "two.toml"]);
}

#[test]
fn the_model_verb_shows_robots_loops_springs_and_loads() {
    let folder = folder("model_verb");
    let text = TWO.to_string()
        + "[[loop]]\nname = \"rod\"\ntype = \"distance\"\na = { link = \"left/rod\", position = [0, 0, -1] }\nb = { link = \"right/rod\", position = [0.6, 0, -0.2] }\n\
           [[spring]]\na = { link = \"left/tip\" }\nb = { link = \"world\" }\nstiffness = 3\nrest_length = 0.5\n\
           [[load]]\njoint = \"right/hinge\"\neffort = 2\n";
    std::fs::write(folder.join("scene.toml"), text).unwrap();
    let report = report(&folder, &["model", "scene.toml", "--json"]);
    assert_eq!(report["robots"][1]["name"], "right");
    assert_eq!(report["model"]["loops"], 1);
    assert_eq!(
        (&report["loops"][0]["type"], &report["loops"][0]["length"]),
        (&Value::from("distance"), &Value::from(1.0))
    );
    assert_eq!(report["loops"][0]["b"]["body"], "right/rod");
    assert_eq!(
        (&report["springs"][0]["stiffness"], &report["springs"][0]["b"]["body"]),
        (&Value::from(3.0), &Value::from("world"))
    );
    assert_eq!(
        (&report["joint_loads"][0]["joint"], &report["joint_loads"][0]["effort"]),
        (&Value::from("right/hinge"), &Value::from(2.0))
    );
    let table = String::from_utf8(run(&folder, &["model", "scene.toml"]).stdout).unwrap();
    for part in ["1 degree of freedom, 1 loop with 1 equation\n", "distance 1 m", "3.000 N/m", "right/hinge", "effort"]
    {
        assert!(table.contains(part), "{part:?} in {table}");
    }
}

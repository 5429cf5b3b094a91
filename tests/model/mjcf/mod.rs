//! MJCF is read as MuJoCo reads it: masses, frames, inertia about joints, weights, springs, actuators and keyframes.

mod actuator_defaults;
mod compiler;
mod contacts;
mod copies;
mod options;
mod pairs;
mod tendons;
mod tuning;
mod whole;

use crate::common::command;
use catena::instant::start::assembly::assemble;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::model::NeverTouch;
use catena::scene::{PackagePath, PairRule, Scene, SceneError, Touching, WarningGroup, read_input};
use catena::session::{Model, Simulation};
use std::path::{Path, PathBuf};

fn bench() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/model/mjcf/bench.xml")
}

/// Results of MuJoCo 4.0.0 for `bench.xml` at its keyframe: the mass matrix of shoulder, swing, twist, extend and grip (row by row, up to the diagonal),
/// and the efforts that hold it there.
const MASSES: [f64; 15] = [
    1.1969337880825388,
    -0.10905790979482503,
    0.28004843607843694,
    0.14326019936668177,
    0.009877429824470152,
    0.04968333472847765,
    -0.17051558661962887,
    -0.4771397758436035,
    -0.12400000000000004,
    1.4525905991858934,
    -0.003687686986481857,
    -0.004841822032150276,
    -0.002302885538292078,
    0.01919071281910052,
    0.0016999999999999737,
];
const HOLDING: [f64; 5] =
    [15.310199807648546, -2.455807944179588, 1.2327798582423237, -2.5799690618917466, -0.1266311422818498];

#[test]
fn masses_weights_and_frames_of_a_chain_are_those_of_mujoco_at_its_keyframe() {
    let model = Model::loader().keyframe("home").load(bench()).expect("a model");
    assert_eq!(model.joint_names(), ["shoulder", "swing", "twist", "extend", "grip"]);
    let (q, v) = model.start().expect("a start");
    // Positions are counted from `ref`, here of the swing.
    let wanted = [0.3, 0.4 - 10_f64.to_radians(), -0.5, 0.05, 0.2];
    assert!(q.iter().zip(wanted).all(|(q, wanted)| (q - wanted).abs() < 1e-15), "{q:?}");
    assert_eq!(v, [1.0, 2.0, 3.0, 4.0, 5.0]);
    let masses = model.mass_matrix(&q).expect("a mass matrix");
    let holding = model.gravity_efforts(&q).expect("efforts");
    let mut known = MASSES.iter();
    for row in 0..5 {
        for column in 0..=row {
            let known = known.next().expect("15 numbers");
            // Both sum some hundred terms of at most the largest entry.
            assert!((masses[(row, column)] - known).abs() < 1e-13, "{row} {column}: {} {known}", masses[(row, column)]);
        }
        assert!((holding[row] - HOLDING[row]).abs() < 1e-12, "{row}: {} {}", holding[row], HOLDING[row]);
    }
    let hand = model.pose("hand", &q).expect("a link").translation.vector;
    let wanted = nalgebra::Vector3::new(-0.3633128378423578, -0.24197471655494107, -0.4665752715047161);
    assert!((hand - wanted).amax() < 1e-14, "{hand}");
    // The upper body is a box and an ellipsoid.
    let mass = model.description().links[model.description().link("upper").expect("a link")].mass;
    assert!((mass - 10.599114857512857).abs() < 1e-13, "{mass}");
}

#[test]
fn limits_springs_friction_and_actuators_are_those_of_the_file() {
    let model = Model::loader().keyframe("home").load(bench()).expect("a model");
    let mechanism = &model.description().mechanism;
    let degrees = f64::to_radians;
    let limits: Vec<(f64, f64)> = mechanism.nonsmooth.limits.iter().map(|limit| (limit.lower, limit.upper)).collect();
    let wanted = [(-40.0, 50.0), (-30.0, 60.0)].map(|(lower, upper)| (degrees(lower), degrees(upper)));
    let near = |one: (f64, f64), other: (f64, f64)| (one.0 - other.0).abs().max((one.1 - other.1).abs()) < 1e-15;
    assert!(near(limits[0], wanted[0]) && limits[1] == (-0.1, 0.2) && near(limits[2], wanted[1]), "{limits:?}");
    let spring = &mechanism.forces.joint_springs[0];
    assert!(spring.stiffness == 2.0 && (spring.rest - degrees(15.0)).abs() < 1e-15, "{spring:?}");
    let friction: Vec<f64> = mechanism.nonsmooth.friction.iter().map(|friction| friction.effort).collect();
    assert_eq!(friction, [0.2; 3], "swing, extend and grip");
    let damping: Vec<f64> = mechanism.forces.joint_dampers.iter().map(|damper| damper.coefficient).collect();
    assert_eq!(damping, [0.1, 0.1, 0.1, 3.0, 0.1]);
    // Efforts that MuJoCo gives at the keyframe, of shoulder, swing, extend and grip.
    let wanted = [("shoulder", 2.1), ("swing", -16.0), ("extend", -12.8), ("grip", 2.5)];
    let (q, v) = model.start().expect("a start");
    for (joint, wanted) in wanted {
        let at = model.joint_names().iter().position(|name| *name == joint).expect("a joint");
        let motor = mechanism.nonsmooth.motors.iter().find(|motor| motor.coordinate.freedom == at).expect("a motor");
        let effort = motor.effort(0.0, q[at], v[at]);
        assert!((effort - wanted).abs() < 1e-13, "{joint}: {effort} {wanted}");
    }
    assert!(mechanism.nonsmooth.motors.iter().any(|motor| motor.law == MotorLaw::Velocity { kd: 4.0 }));
}

#[test]
fn what_touches_has_the_larger_friction_and_what_has_no_counterpart_is_said_with_its_line() {
    let model = Model::load(bench()).expect("a model");
    let mechanism = &model.description().mechanism;
    let owners: Vec<&str> = mechanism.nonsmooth.colliders.iter().map(|collider| collider.name.as_str()).collect();
    assert_eq!(owners, ["upper", "lower", "lower", "hand", "ground", "geom2"]);
    let on = |name: &str| {
        let pairs = mechanism.nonsmooth.pairs.iter().filter(|pair| owners[pair.b] == name);
        pairs.map(|pair| pair.friction).collect::<Vec<f64>>()
    };
    assert!(on("ground").iter().all(|friction| *friction == 0.8), "{:?}", on("ground"));
    // It starts as its bodies are.
    assert_eq!(model.start().expect("a start").0, [0.0; 5]);
    let warnings = model.warnings();
    let said = |what: &str| assert!(warnings.iter().any(|line| line.contains(what)), "{what}: {warnings:#?}");
    said("bench.xml:38: a constraint that is not active");
    said("bench.xml:45: the scene starts as its bodies are; --keyframe home");
    // Links of the arm touch each other, but for neighbours.
    assert_eq!(model.description().contact.settings.self_contact, Some(true));
    said("ignored: line 15: <light> of <worldbody>");
}

fn read(name: &str, text: &str) -> Result<Scene, SceneError> {
    read_at(name, text, None)
}

/// Reads a model that starts at a keyframe.
fn read_at(name: &str, text: &str, keyframe: Option<&str>) -> Result<Scene, SceneError> {
    let folder = command::folder(name);
    std::fs::write(folder.join("model.xml"), text).expect("written");
    read_input(&folder.join("model.xml"), keyframe, &PackagePath::default())
}

#[test]
fn free_bodies_loops_excluded_pairs_and_followers_become_those_of_a_scene() {
    let text = "<mujoco><compiler angle='radian'/><worldbody>
      <body name='cube' pos='0 0 1' quat='0 0 0 1'><freejoint name='root'/><geom type='box' size='.1 .2 .3' density='500'/></body>
      <body name='arm' pos='1 0 0'><joint name='a' axis='0 1 0'/><geom type='sphere' size='.1' mass='1' pos='0.2 0 0'/>
        <body name='rod' pos='0 0 -1'><joint name='b' axis='0 1 0'/><geom type='capsule' size='.05 .2' mass='2'/></body></body>
    </worldbody><contact><exclude body1='cube' body2='rod'/><exclude body1='arm' body2='rod'/></contact>
    <equality><connect body1='rod' body2='cube' anchor='0 0 -0.5'/><joint joint1='b' joint2='a' polycoef='0.1 -2'/></equality></mujoco>";
    let scene = read("mjcf_free", text).expect("a scene");
    let names: Vec<(&str, bool)> = scene.robots.iter().map(|robot| (robot.name.as_str(), robot.floating)).collect();
    assert_eq!(names, [("cube", true), ("arm", false)]);
    let inertial = scene.robots[0].robot.links[0].inertial.as_ref().expect("a mass");
    // 0.2 · 0.4 · 0.6 m³ of 500 kg/m³.
    assert!((inertial.mass - 24.0).abs() < 1e-14 && (inertial.inertia[(0, 0)] - 1.04).abs() < 1e-14, "{inertial:?}");
    let closing = &scene.loops[0];
    assert_eq!((closing.a.point.name.as_str(), closing.b.point.name.as_str()), ("arm/rod", "cube/cube"));
    assert_eq!(closing.a.point.position.as_slice(), [0.0, 0.0, -0.5]);
    // (1, 0, −1.5) of the world, seen from a cube at (0, 0, 1) that is turned by 180° about z.
    let place = closing.b.point.position;
    assert!((place - nalgebra::Vector3::new(-1.0, 0.0, -2.5)).amax() < 1e-15, "{place}");
    let mimic = scene.robots[1].robot.joints.iter().find_map(|joint| joint.mimic.clone()).expect("a follower");
    assert_eq!((mimic.joint.as_str(), mimic.multiplier, mimic.offset), ("a", -2.0, 0.1));
    let rules: Vec<_> =
        scene.contact.rules.iter().map(|rule| (rule.a.as_str(), rule.b.as_str(), rule.ignore)).collect();
    assert_eq!(rules, [("cube/cube", "arm/rod", Some(true)), ("arm/arm", "arm/rod", Some(true))]);
    assert_eq!(scene.contact.self_contact, Some(true));
    // Bits of contact that never meet: the robot touches the floor alone.
    let masked = text.replace("<geom type", "<geom contype='1' conaffinity='2' type");
    assert_eq!(read("mjcf_masked", &masked).expect("a scene").contact.self_contact, Some(false));
    assert_eq!(scene.contact.touching, Some(Touching::All));
    let off = text.replace("<worldbody>", "<option><flag contact='disable' gravity='disable'/></option><worldbody>");
    let scene = read("mjcf_flags", &off).expect("a scene");
    assert_eq!((scene.contact.touching, scene.gravity), (Some(Touching::None), Some(nalgebra::Vector3::zeros())));
}

#[test]
fn links_that_a_loop_joins_do_not_touch_though_they_are_of_two_children_of_the_world() {
    // A slider crank whose rod and slider overlap at the pin; beside it another ball, which the rod may touch.
    let text = "<mujoco><worldbody><geom type='plane' size='5 5 .1'/>
      <body name='crank' pos='0 0 1'><joint name='c' axis='0 1 0'/><geom type='box' pos='.15 0 0' size='.15 .02 .02' mass='.5'/>
        <body name='rod' pos='.3 0 0'><joint name='r' axis='0 1 0'/><geom type='box' pos='.4 0 0' size='.4 .01 .01' mass='.4'/></body></body>
      <body name='ball' pos='0 0 3'><freejoint/><geom type='sphere' size='.04' mass='.8'/></body>
      <body name='slider' pos='1.1 0 1'><joint name='s' type='slide' axis='1 0 0'/><geom type='sphere' size='.04' mass='.8'/></body>
      <body name='other' pos='0 1 3'><freejoint/><geom type='sphere' size='.04' mass='.8'/></body>
    </worldbody><equality><KIND body1='rod' body2='slider' anchor='.8 0 0'/></equality></mujoco>";
    for kind in ["connect", "weld"] {
        let scene = read(&format!("mjcf_{kind}"), &text.replace("KIND", kind)).expect("a scene");
        let reasons = |scene: &Scene| {
            let (model, _) = catena::model::Model::from_scene(scene).expect("a model");
            let name = |of: usize| model.mechanism.nonsmooth.colliders[of].name.clone();
            let touch: Vec<_> =
                model.mechanism.nonsmooth.pairs.iter().map(|pair| [name(pair.a), name(pair.b)]).collect();
            let left = model.contact.left_out.iter().map(|left| ([name(left.pair.a), name(left.pair.b)], left.because));
            (touch, left.collect::<Vec<_>>())
        };
        let pin = ["crank/rod", "slider/slider"].map(str::to_string);
        let is_pin = |names: &[String; 2]| pin.iter().all(|name| names.contains(name));
        let (touch, left) = reasons(&scene);
        assert!(left.iter().any(|(names, because)| is_pin(names) && *because == NeverTouch::Neighbours), "{left:?}");
        assert!(!touch.iter().any(is_pin), "{touch:?}");
        // Others of the same run of pairs still touch, and so does the floor.
        for other in ["ball/ball", "other/other", "geom1"] {
            let meets = |names: &[String; 2]| names.contains(&pin[0]) && names.iter().any(|name| name == other);
            assert!(touch.iter().any(meets), "{other}: {touch:?}");
        }
        // A pair that is asked for stays.
        let mut asked = scene.clone();
        let [a, b] = pin.clone();
        let rule =
            PairRule { a, b, friction: None, restitution: None, moments: [None; 2], ignore: Some(false), line: 1 };
        asked.contact.rules.push(rule);
        assert!(reasons(&asked).0.iter().any(is_pin));
        // The loop holds them inside each other.
        let (model, start) = catena::model::Model::from_scene(&asked).expect("a model");
        let mut state = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
        let error = assemble(&model.mechanism, &mut state).expect_err("it cannot start").to_string();
        assert!(error.starts_with("\"crank/rod\" and \"slider/slider\" start ") && !error.contains("NaN"), "{error}");
    }
}

#[test]
fn what_is_wrong_is_said_in_one_line_with_file_and_line() {
    let body = |inside: &str| {
        format!("<mujoco><worldbody>\n<body><joint name='j'/>\n{inside}<geom size='1'/></body></worldbody>")
    };
    for (text, said) in [
        ("<mujoco/>".to_string(), "model.xml:1: no body of the model has a joint"),
        (
            body("<geom type='box' size='1 1'/>") + "</mujoco>",
            "model.xml:3: <geom size=\"1 1\">: its shape needs 3 numbers",
        ),
        (
            body("<geom size='1' quat='0 0 0 0'/>") + "</mujoco>",
            "model.xml:3: <geom quat=\"0 0 0 0\">: it has no direction",
        ),
        (body("<geom mesh='m'/>") + "</mujoco>", "model.xml:3: <geom mesh=\"m\">: there is no such mesh"),
        (body("<joint type='screw'/>") + "</mujoco>", "model.xml:3: <joint type=\"screw\">: \"screw\" is none of"),
        (
            body("") + "<actuator>\n<motor joint='k'/></actuator></mujoco>",
            "model.xml:4: <motor joint=\"k\">: there is no such joint",
        ),
        ("<mujoco>\n<include file='none.xml'/></mujoco>".to_string(), "model.xml:2: <include file=\"none.xml\">: "),
        ("<mujoco>\n<include file='model.xml'/></mujoco>".to_string(), "files include each other without an end"),
        ("<mujoco><worldbody></mujoco>".to_string(), "model.xml:1: is not well-formed XML"),
    ] {
        let error = read("mjcf_errors", &text).expect_err(&text).to_string();
        assert!(error.contains(said) && error.lines().count() == 1, "{text}: {error}");
    }
    let error = read_input(&bench(), Some("away"), &PackagePath::default()).expect_err("no keyframe").to_string();
    assert!(error.contains("no keyframe \"away\"; there are \"home\""), "{error}");
}

#[test]
fn a_model_runs_as_the_scene_that_was_made_of_it_and_keeps_its_energy() {
    let text = "<mujoco><worldbody><body pos='0 0 2'><joint axis='0 1 0' pos='0 0 0.5'/>
      <geom type='capsule' fromto='0 0 0.5 0 0 -0.5' size='0.01' mass='3'/></body></worldbody></mujoco>";
    let folder = command::folder("mjcf_runs");
    std::fs::write(folder.join("rod.xml"), text).expect("written");
    let model = Model::load(folder.join("rod.xml")).expect("a model");
    assert!(
        model.description().warnings.iter().all(|warning| warning.group != WarningGroup::Odd),
        "{:?}",
        model.warnings()
    );
    let mut simulation =
        Simulation::new(&model).duration(2.0).tolerance(1e-10).start([("body1_joint", 1.0)]).expect("a start");
    simulation.run().expect("a run");
    let rate = simulation.velocity("body1_joint").expect("a joint")[0];
    let angle = simulation.position("body1_joint").expect("a joint")[0];
    // A capsule of length 1, about its upper end: I θ̇²/2 = m g l/2 (cos θ − cos 1). Its inertia follows from cylinder and half spheres.
    let (r, l, m) = (0.01_f64, 1.0_f64, 3.0_f64);
    let of_cylinder = m * l / (l + 4.0 / 3.0 * r);
    let ends = m - of_cylinder;
    let across = of_cylinder * (3.0 * r * r + l * l) / 12.0 + ends * (0.4 * r * r + 0.25 * l * l + 0.375 * l * r);
    let inertia = across + m * 0.25;
    let (kinetic, fallen) = (0.5 * inertia * rate * rate, m * 9.81 * 0.5 * (angle.cos() - 1.0_f64.cos()));
    assert!((kinetic - fallen).abs() < 1e-8, "{kinetic} {fallen}");
}

#[test]
fn the_mass_of_a_mesh_is_that_of_the_solid_in_it_and_a_total_mass_scales_all() {
    let folder = command::folder("mjcf_mesh");
    // A box of 1 × 2 × 3 m with one corner at the origin, scaled to 0.1.
    let corners: String =
        (0..8).map(|corner| format!("v {} {} {}\n", corner & 1, 2 * (corner >> 1 & 1), 3 * (corner >> 2))).collect();
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(folder.join("box.obj"), format!("{corners}{faces}")).expect("written");
    for (inertia, total) in [("legacy", None), ("exact", None), ("exact", Some(12.0))] {
        let total_mass = total.map_or(String::new(), |mass| format!("<compiler settotalmass='{mass}'/>"));
        let text = format!(
            "<mujoco>{total_mass}<asset><mesh file='box.obj' scale='.1 .1 .1' inertia='{inertia}'/></asset><worldbody>\
             <body><joint/><geom type='mesh' mesh='box' density='1000'/></body></worldbody></mujoco>"
        );
        let file = folder.join("model.xml");
        std::fs::write(&file, text).expect("written");
        let scene = read_input(&file, None, &PackagePath::default()).expect("a scene");
        let inertial = scene.robots[0].robot.links[0].inertial.clone().expect("a mass");
        let mass = total.unwrap_or(6.0);
        let moments = mass / 12.0 * nalgebra::Vector3::new(0.13, 0.10, 0.05);
        assert!((inertial.mass - mass).abs() < 1e-13, "{inertia}: {}", inertial.mass);
        let center: nalgebra::Vector3<f64> =
            inertial.origin.translation.vector - nalgebra::Vector3::new(0.05, 0.1, 0.15);
        assert!(center.amax() < 1e-15, "{inertia}: {center}");
        assert!((inertial.inertia - nalgebra::Matrix3::from_diagonal(&moments)).amax() < 1e-14, "{inertia}");
        assert_eq!(scene.robots[0].robot.links[0].collisions.len(), 1);
    }
}

#[test]
fn armature_of_hinges_and_slides_is_the_inertia_of_their_rotors() {
    let folder = std::env::temp_dir().join(format!("catena-mjcf-armature-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let matrix = |armature: &str| {
        let text = format!(
            "<mujoco><default><joint {armature}/></default><worldbody><body name='a'><joint name='turn' axis='0 1 0'/>\
             <geom type='box' size='.1 .1 .3' pos='0 0 -.3'/><body name='b' pos='0 0 -.6'><joint name='slide' type='slide' axis='1 0 0'/>\
             <geom type='box' size='.1 .1 .1'/></body></body></worldbody></mujoco>"
        );
        let file = folder.join("two.xml");
        std::fs::write(&file, text).expect("a model");
        let model = Model::load(&file).expect("a model");
        assert!(!model.description().warning_lines().any(|line| line.contains("armature")));
        model.mass_matrix(&[0.3, 0.1]).expect("a mass matrix")
    };
    let more = matrix("armature='0.25'") - matrix("damping='0'");
    // Roundings of entries of some hundred kg m².
    assert!((more - nalgebra::DMatrix::identity(2, 2) * 0.25).amax() < 1e-12);
}

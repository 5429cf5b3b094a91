//! Limits, friction, damping, motors and speeds are those of the URDF, or what the scene file says instead.

use super::{LIMBED, TWO, build, folder};
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::model::Model;

/// The name of the joint of a coordinate's body.
fn joint(model: &Model, body: usize) -> &str {
    &model.mechanism.bodies[body].joint.name
}

fn limits(model: &Model) -> Vec<(&str, f64, f64, f64)> {
    let limits = model.mechanism.nonsmooth.limits.iter();
    limits.map(|limit| (joint(model, limit.coordinate.body), limit.lower, limit.upper, limit.restitution)).collect()
}

fn friction(model: &Model) -> Vec<(&str, f64)> {
    let friction = model.mechanism.nonsmooth.friction.iter();
    friction.map(|friction| (joint(model, friction.coordinate.body), friction.effort)).collect()
}

fn damping(model: &Model) -> Vec<f64> {
    model.mechanism.forces.joint_dampers.iter().map(|damper| damper.coefficient).collect()
}

fn said(model: &Model, part: &str) -> Vec<String> {
    model.warnings.iter().map(ToString::to_string).filter(|warning| warning.contains(part)).collect()
}

#[test]
fn limits_friction_damping_and_speeds_are_those_of_the_urdf() {
    let folder = folder("of_urdf");
    let (model, ..) = build(&folder, LIMBED);
    // Equal limits lock a joint; both at zero, or none, are no limits, which is said.
    assert_eq!(limits(&model), [("hinge", -1.0, 2.0, 0.0), ("slide", 0.1, 0.1, 0.0)]);
    assert_eq!(model.mechanism.limits, model.mechanism.nonsmooth.limits);
    let unlimited = said(&model, "<limit>");
    assert_eq!(unlimited.len(), 1, "{unlimited:?}");
    assert!(unlimited[0].contains("joint \"finger\": its <limit> has lower = upper = 0"), "{unlimited:?}");
    assert!(unlimited[0].ends_with("; the same for 1 more joint"), "{unlimited:?}");
    assert_eq!(friction(&model), [("hinge", 0.25)]);
    let unsimulated = said(&model, "friction is not simulated");
    assert!(unsimulated.len() == 1 && unsimulated[0].contains("joint \"ball\""), "{unsimulated:?}");
    assert_eq!(damping(&model), [0.5]);
    let speeds = &model.mechanism.nonsmooth.speeds;
    let speeds: Vec<_> = speeds.iter().map(|limit| (joint(&model, limit.coordinate.body), limit.speed)).collect();
    assert_eq!(speeds, [("hinge", 4.0), ("finger", 1.0), ("thumb", 1.0)]);
    assert!(model.mechanism.nonsmooth.motors.is_empty());
}

#[test]
fn a_joint_of_the_scene_file_replaces_what_the_urdf_says_and_leaves_the_rest() {
    let folder = folder("overrides");
    let scene = |keys: &str| format!("{LIMBED}[[joint]]\nname = \"hinge\"\n{keys}\n");
    let hinge = |keys: &str| build(&folder, &scene(keys)).0;
    let model = hinge("limit = [-0.5, inf]\nrestitution = 0.75\nfriction = 2\ndamping = 3");
    assert_eq!(limits(&model)[0], ("hinge", -0.5, f64::INFINITY, 0.75));
    assert_eq!(model.mechanism.limits, model.mechanism.nonsmooth.limits);
    assert_eq!((friction(&model), damping(&model)), (vec![("hinge", 2.0)], vec![3.0]));
    let model = hinge("limit = \"none\"\nfriction = 0\ndamping = 0");
    assert_eq!(limits(&model), [("slide", 0.1, 0.1, 0.0)]);
    assert_eq!((friction(&model), damping(&model)), (vec![], vec![]));
    // Restitution alone keeps the limits of the URDF, and damping alone everything else.
    assert_eq!(limits(&hinge("restitution = 1"))[0], ("hinge", -1.0, 2.0, 1.0));
    let model = hinge("damping = 7");
    assert_eq!((limits(&model)[0], friction(&model)), (("hinge", -1.0, 2.0, 0.0), vec![("hinge", 0.25)]));
    assert_eq!(limits(&hinge("limit = [-inf, inf]")).len(), 1);
    // A continuous joint gets limits, one with lower = upper = 0 is locked, and a restitution of nothing is said.
    let text = format!(
        "{LIMBED}[[joint]]\nname = \"wheel\"\nlimit = [-1, 1]\n[[joint]]\nname = \"finger\"\nlimit = [0, 0]\n\
         [[joint]]\nname = \"thumb\"\nrestitution = 0.5\n"
    );
    let (model, ..) = build(&folder, &text);
    assert_eq!(limits(&model)[2..], [("wheel", -1.0, 1.0, 0.0), ("finger", 0.0, 0.0, 0.0)]);
    let idle = said(&model, "restitution does nothing");
    assert!(idle.len() == 1 && idle[0].contains("scene.toml:10: joint \"thumb\""), "{idle:?}");
    assert!(said(&model, "lower = upper = 0").is_empty());
}

#[test]
fn settings_of_one_of_several_robots_leave_the_others_alone() {
    let folder = folder("one_of_several");
    let text = format!("{TWO}[[joint]]\nname = \"right/hinge\"\nlimit = [0, 1]\nfriction = 0.5\n");
    let (model, ..) = build(&folder, &text);
    assert_eq!(limits(&model), [("right/hinge", 0.0, 1.0, 0.0)]);
    assert_eq!(friction(&model), [("right/hinge", 0.5)]);
}

#[test]
fn motors_have_the_law_of_their_kind_and_the_bound_of_the_file_or_of_the_urdf() {
    let folder = folder("motors");
    let motor = |joint: &str, keys: &str| format!("[[motor]]\njoint = \"{joint}\"\n{keys}\n");
    let text = [
        LIMBED.to_string(),
        motor("hinge", "kind = \"position\"\ntarget = 0.5\nkp = 100\nkd = 5\ninterpolation = \"linear\""),
        motor("slide", "kind = \"velocity\"\ntarget = 2\nkd = 5\nperiod = 0.01"),
        motor("limbs/wheel", "kind = \"effort\"\ntarget = -3\nmax_effort = 2.5"),
        motor("finger", "kind = \"position\"\ntarget = 1\nkp = 0\nmax_effort = inf"),
    ];
    let (model, ..) = build(&folder, &text.concat());
    let motors = &model.mechanism.nonsmooth.motors;
    let all: Vec<_> = motors
        .iter()
        .map(|motor| (joint(&model, motor.coordinate.body), motor.law, motor.target.value(0.0), motor.period))
        .collect();
    assert_eq!(
        all,
        [
            ("hinge", MotorLaw::Position { kp: 100.0, kd: 5.0 }, 0.5, 0.0),
            ("slide", MotorLaw::Velocity { kd: 5.0 }, 2.0, 0.01),
            ("wheel", MotorLaw::Effort, -3.0, 0.0),
            // One that mimics another may have a motor of its own.
            ("finger", MotorLaw::Position { kp: 0.0, kd: 0.0 }, 1.0, 0.0),
        ]
    );
    // An effort of zero in a URDF is not known.
    let bounds: Vec<f64> = motors.iter().map(|motor| motor.max_effort).collect();
    assert_eq!(bounds, [30.0, f64::INFINITY, 2.5, f64::INFINITY]);
}

#[test]
fn targets_are_numbers_lists_and_csv_files_with_or_without_a_header() {
    let folder = folder("targets");
    std::fs::create_dir_all(folder.join("tables")).expect("a folder");
    std::fs::write(folder.join("tables/with.csv"), "\u{feff}time [s], angle [rad]\r\n0, 1\r\n 2 ,3\r\n\r\n")
        .expect("written");
    std::fs::write(folder.join("without.csv"), "0,1\n2,3").expect("written");
    let value = |target: &str| {
        let text = format!("{LIMBED}[[motor]]\njoint = \"hinge\"\nkind = \"effort\"\ntarget = {target}\n");
        let (model, ..) = build(&folder, &text);
        let target = &model.mechanism.nonsmooth.motors[0].target;
        let files: Vec<String> = model.files().map(|file| file.display().to_string()).collect();
        (
            [-1.0, 0.5, 2.0, 9.0].map(|time| target.value(time)),
            files.iter().filter(|file| file.ends_with(".csv")).count(),
        )
    };
    assert_eq!(value("4"), ([4.0; 4], 0));
    assert_eq!(value("[[0, 1], [2.0, 3]]"), ([1.0, 1.5, 3.0, 3.0], 0));
    assert_eq!(value("[[0, 1], [2, 3]]\ninterpolation = \"hold\""), ([1.0, 1.0, 3.0, 3.0], 0));
    assert_eq!(value("\"tables/with.csv\""), ([1.0, 1.5, 3.0, 3.0], 1));
    assert_eq!(value("\"without.csv\"\ninterpolation = \"cubic\""), ([1.0, 1.5, 3.0, 3.0], 1));
}

//! Motors named by patterns and lists, and motors that hold what a run starts from, are those that a file would name one by one.

use super::{LIMBED, build, folder, read, refusal};
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::model::Model;
use catena::scene::Scene;
use catena::session::{Hold, Model as Loaded, Simulation};
use std::path::Path;

const DRIVE: &str = "kind = \"position\"\nkp = 100\nkd = 5\n";

fn mechanism(scene: &Scene) -> String {
    format!("{:?}", Model::from_scene(scene).expect("a model").0.mechanism)
}

#[test]
fn a_pattern_and_a_list_drive_the_joints_that_they_name_one_by_one() {
    let folder = folder("patterns");
    let motor = |joint: &str, rest: &str| format!("[[motor]]\njoint = {joint}\n{rest}");
    let drive = format!("{DRIVE}target = 0.2\n");
    let one_by_one: String =
        ["hinge", "slide", "wheel", "thumb"].map(|joint| motor(&format!("{joint:?}"), &drive)).concat();
    let long = mechanism(&read(&folder, &format!("{LIMBED}{one_by_one}")).unwrap());
    // "finger" follows another joint, "cap" moves no mass, the others have several freedoms, or are fixed.
    for short in [
        motor("\"*\"", &drive),
        motor("[\"hinge\", \"slide\", \"wheel\", \"thumb\"]", &drive),
        motor("[\"hinge\", \"*\"]", &drive),
        motor("\"limbs/*\"", &drive),
        motor("[\"hinge\", \"s*\", \"*h*\"]", &drive),
    ] {
        assert_eq!(mechanism(&read(&folder, &format!("{LIMBED}{short}")).unwrap()), long, "{short}");
    }
    // The name of a joint goes before a pattern, also before a pattern that comes first.
    let own = motor("\"wheel\"", "kind = \"effort\"\ntarget = 3\n");
    let (model, ..) = build(&folder, &format!("{LIMBED}{}{own}", motor("\"*\"", &drive)));
    let laws: Vec<MotorLaw> = model.mechanism.nonsmooth.motors.iter().map(|motor| motor.law).collect();
    let position = MotorLaw::Position { kp: 100.0, kd: 5.0 };
    assert_eq!(laws, [position, position, position, MotorLaw::Effort]);
    for (text, said) in [
        (motor("\"knee*\"", &drive), "scene.toml:4: motor on \"knee*\": no joint that turns"),
        (motor("\"ball\"", &drive), "motor on \"ball\": joint \"ball\" has several degrees of freedom"),
        (motor("[]", &drive), "scene.toml:4: motor.joint: the list is empty"),
        (motor("[\"hinge\", \"hinge\"]", &drive), "motor on \"hinge\": the joint already has the motor of line 4"),
        (
            motor("\"hinge\"", "kind = \"effort\"\ntarget = \"start\"\n"),
            "scene.toml:6: motor on \"hinge\": only a motor of the kind position",
        ),
    ] {
        let message = refusal(&folder, &format!("{LIMBED}{text}"));
        assert!(message.contains(said) && message.lines().count() == 1, "{text}: {message}");
    }
}

/// Energies and steps of a second of motion.
fn told(model: &Loaded, start: &[(&str, f64)]) -> (f64, f64, f64) {
    let mut simulation = Simulation::new(model).duration(1.0).start(start.iter().copied()).expect("a start");
    simulation.run().expect("a run");
    let report = simulation.finish().expect("a report");
    (report.energy.initial, report.energy.r#final, report.energy.work)
}

fn load(folder: &Path, text: &str, hold: Option<Hold>) -> Loaded {
    let file = folder.join("held.toml");
    std::fs::write(&file, text).expect("written");
    let loader = hold.into_iter().fold(Loaded::loader(), |loader, hold| loader.hold(hold));
    loader.load(file).expect("a model")
}

#[test]
fn a_motor_that_aims_at_the_start_is_one_whose_target_is_the_number_there() {
    let folder = folder("start_targets");
    let robot = "[[robot]]\nurdf = \"double.urdf\"\npositions = { shoulder = 0.3, elbow = -0.5 }\n";
    let at = |joint: &str, target: &str| format!("[[motor]]\njoint = \"{joint}\"\n{DRIVE}target = {target}\n");
    let long = load(&folder, &format!("{robot}{}{}", at("shoulder", "0.3"), at("elbow", "-0.5")), None);
    let asked = told(&long, &[]);
    assert_eq!(told(&load(&folder, &format!("{robot}{}", at("*", "\"start\"")), None), &[]), asked);
    let gains = Hold { kp: Some(100.0), kd: Some(5.0), gravity: None };
    assert_eq!(told(&load(&folder, robot, Some(gains)), &[]), asked);
    // The start of the run counts, whoever gives it.
    let elsewhere = load(&folder, &robot.replace("0.3", "0.9"), Some(gains));
    assert_eq!(told(&elsewhere, &[("shoulder", 0.3)]), asked);
}

#[test]
fn a_robot_that_is_held_without_gains_gives_way_by_its_weight_over_the_stiffness_of_ten_hertz() {
    let folder = folder("held");
    let urdf = "<robot name='arm'><link name='base'/><link name='rod'><inertial><origin xyz='1 0 0'/><mass value='2'/>\
        <inertia ixx='0' iyy='0' izz='0' ixy='0' ixz='0' iyz='0'/></inertial></link>\
        <joint name='hinge' type='continuous'><parent link='base'/><child link='rod'/><axis xyz='0 1 0'/></joint></robot>";
    std::fs::write(folder.join("arm.urdf"), urdf).expect("written");
    let model = load(&folder, "[[robot]]\nurdf = \"arm.urdf\"\n", Some(Hold::default()));
    let mut simulation = Simulation::new(&model).duration(5.0).tolerance(1e-9);
    simulation.run().expect("a run");
    let angle = simulation.position("hinge").expect("a joint")[0];
    // kp θ = m g l cos θ with kp = m l² ω²: θ = g/(l ω²) cos θ. The critically damped motion is over after 5 s: e^(−62.8·5).
    let wanted = 9.81 / (20.0 * std::f64::consts::PI).powi(2);
    let wanted = wanted * (wanted * wanted.cos()).cos();
    assert!((angle - wanted).abs() < 1e-9, "{angle} {wanted}");
}

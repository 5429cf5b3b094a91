//! Wheels on axles that are guided, carried or driven: cylinders that stand on a plane by both rims, against closed forms.

use crate::scene_files::{apart, joint, report, scene_of};
use catena::report::{LinkReport, Report};
use std::path::Path;

/// Closed forms are met to this (m, rad): tolerances of 1e-11 m and their factors of some ten.
const BOUND: f64 = 1e-10;
/// Mass of a carriage and of its wheel (kg), the wheel's moment of inertia about its axle [kg m²], and its radius (m).
const CARRIAGE: f64 = 1.7;
const WHEEL: f64 = 0.8;
const INERTIA: f64 = 0.006;
const RADIUS: f64 = 0.12;

fn link(name: &str, mass: f64, about: [f64; 3], shape: &str) -> String {
    let [x, y, z] = about;
    format!(
        "<link name='{name}'><inertial><mass value='{mass}'/><inertia ixx='{x}' iyy='{y}' izz='{z}' ixy='0' ixz='0' iyz='0'/></inertial>\
         {shape}</link>"
    )
}

fn wheel(name: &str, shape: &str) -> String {
    let shape = format!("<collision><geometry>{shape}</geometry></collision>");
    link(name, WHEEL, [0.004, 0.004, INERTIA], &shape)
}

fn cylinder() -> String {
    wheel("wheel", &format!("<cylinder radius='{RADIUS}' length='0.05'/>"))
}

/// Its axle is y but for a rounding.
const AXLE: &str = "rpy='-1.5707963267948966 0 0'";

/// A carriage on a slide along x and one along z, with a link without mass between them.
fn on_slides() -> String {
    format!(
        "<link name='base'/><link name='between'/>{}{}\
         <joint name='x' type='prismatic'><parent link='base'/><child link='between'/><origin xyz='0 0 {RADIUS}'/><axis xyz='1 0 0'/>\
         <limit lower='-50' upper='50' effort='9' velocity='99'/></joint>\
         <joint name='z' type='prismatic'><parent link='between'/><child link='carriage'/><axis xyz='0 0 1'/>\
         <limit lower='-50' upper='50' effort='9' velocity='99'/></joint>\
         <joint name='spin' type='continuous'><parent link='carriage'/><child link='wheel'/><origin {AXLE}/><axis xyz='0 0 1'/></joint>",
        link("carriage", CARRIAGE, [0.01; 3], ""),
        cylinder()
    )
}

const FLOOR: &str = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\nfriction = 0.7\n";

/// The mass that rolls: m + M + I/r² (kg).
fn rolling() -> f64 {
    CARRIAGE + WHEEL + INERTIA / (RADIUS * RADIUS)
}

fn run(file: &Path, duration: f64) -> Report {
    let end = report(file, &[], &[], Some(duration), 1e-11);
    assert!(end.energy.max_relative_error < 1e-11, "{:?}", end.energy);
    assert_eq!((end.method.crowd.steps, end.energy.impacts), (0, 0.0));
    end
}

#[test]
fn a_wheel_at_rest_under_a_carriage_on_slides_begins_to_roll() {
    // Gravity is slanted by as much as a slope would be.
    let along = -0.9;
    let text = format!("[scene]\ngravity = [{along}, 0, -9.7]\n[[robot]]\nurdf = \"robot.urdf\"\n{FLOOR}");
    let end = run(&scene_of("wheel_on_slides", &on_slides(), &text), 1.6);
    let wanted = 0.5 * (CARRIAGE + WHEEL) * along / rolling() * 1.6 * 1.6;
    let (x, _) = joint(&end, "x");
    assert!((x - wanted).abs() < BOUND, "{x} instead of {wanted}");
    let (turned, _) = joint(&end, "spin");
    assert!((turned - x / RADIUS).abs() < 10.0 * BOUND, "{turned} rad over {x} m");
}

#[test]
fn a_wheel_at_rest_begins_to_roll_under_a_force_that_grows_from_zero() {
    let (most, frequency, duration) = (4.0, 2.5, 1.2);
    let text = format!(
        "[[robot]]\nurdf = \"robot.urdf\"\n{FLOOR}\
         [[motor]]\njoint = \"x\"\nkind = \"effort\"\ntarget = {{ formula = \"a*sin(w*t)\", a = {most}, w = {frequency} }}\n"
    );
    let end = run(&scene_of("wheel_under_sine", &on_slides(), &text), duration);
    let wanted = most / (rolling() * frequency) * (duration - (frequency * duration).sin() / frequency);
    let (x, _) = joint(&end, "x");
    assert!((x - wanted).abs() < BOUND, "{x} instead of {wanted}");
}

#[test]
fn a_wheel_under_a_carriage_on_a_planar_joint_turns_in_its_hinge_alone() {
    let urdf = format!(
        "<link name='base'/>{}{}\
         <joint name='plane' type='planar'><parent link='base'/><child link='carriage'/><origin xyz='0 0 {RADIUS}'/><axis xyz='0 1 0'/></joint>\
         <joint name='spin' type='continuous'><parent link='carriage'/><child link='wheel'/><origin {AXLE}/><axis xyz='0 0 1'/></joint>",
        link("carriage", CARRIAGE, [0.01; 3], ""),
        cylinder()
    );
    let along = -1.1;
    let text = format!("[scene]\ngravity = [{along}, 0, -9.7]\n[[robot]]\nurdf = \"robot.urdf\"\n{FLOOR}");
    let end = run(&scene_of("wheel_on_plane", &urdf, &text), 1.5);
    let own: &LinkReport = &end.links.iter().find(|(name, _)| name == "carriage").expect("a link").1;
    let wanted = 0.5 * (CARRIAGE + WHEEL) * along / rolling() * 1.5 * 1.5;
    assert!((own.position[0] - wanted).abs() < BOUND, "{} instead of {wanted}", own.position[0]);
    let (turned, _) = joint(&end, "spin");
    assert!((turned - wanted / RADIUS).abs() < 10.0 * BOUND, "{turned} rad");
}

#[test]
fn a_wheel_on_a_trailing_arm_takes_the_speed_of_its_belt_in_one_stop() {
    let (speed, arm, hinge) = (0.45, 0.5, 0.3_f64);
    let angle = ((hinge - RADIUS) / arm).asin();
    let urdf = format!(
        "<link name='base'/><link name='arm'><inertial><origin xyz='0.25 0 0'/><mass value='1'/><inertia ixx='0.01' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/>\
         </inertial></link>{}\
         <joint name='a' type='continuous'><parent link='base'/><child link='arm'/><origin xyz='0 0 {hinge}'/><axis xyz='0 1 0'/></joint>\
         <joint name='spin' type='continuous'><parent link='arm'/><child link='wheel'/><origin xyz='{arm} 0 0' {AXLE}/><axis xyz='0 0 1'/></joint>",
        cylinder()
    );
    let text = format!(
        "[[robot]]\nurdf = \"robot.urdf\"\npositions = {{ a = {angle} }}\n{FLOOR}surface_velocity = [{speed}, 0, 0]\n"
    );
    let file = scene_of("wheel_on_belt", &urdf, &text);
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let end = report(&file, &[], &[], Some(1.0), tolerance);
        let (_, rate) = joint(&end, "spin");
        // The slip is stopped to 1e-7 of the speeds.
        assert!((rate + speed / RADIUS).abs() < 1e-6, "{rate} at {tolerance}");
        assert_eq!(end.method.crowd.steps, 0, "at {tolerance}");
        let kinds: Vec<&str> = end.events.list.iter().map(|event| event.kind.as_str()).collect();
        assert!(kinds.iter().all(|kind| *kind == "stick") && kinds.len() <= 2, "at {tolerance}: {kinds:?}");
        // Half of the work of the belt turns the wheel.
        let kinetic = 0.5 * INERTIA * (speed / RADIUS).powi(2);
        assert!((end.energy.work - 2.0 * kinetic).abs() < 1e-6, "{:?}", end.energy);
    }
}

#[test]
fn a_robot_with_a_caster_lands_and_drives_without_steps_of_first_order() {
    let sphere = |name: &str| wheel(name, &format!("<sphere radius='{RADIUS}'/>"));
    let side = |name: &str, y: f64| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='chassis'/><child link='{name}_wheel'/><origin xyz='-0.1 {y} 0' {AXLE}/>\
             <axis xyz='0 0 1'/></joint>"
        )
    };
    let urdf = format!(
        "{}{}{}{}{}{}<joint name='swivel' type='spherical'><parent link='chassis'/><child link='caster'/><origin xyz='0.14 0 -0.09'/></joint>",
        link("chassis", 3.0, [0.02, 0.03, 0.04], ""),
        sphere("left_wheel"),
        sphere("right_wheel"),
        link("caster", 0.1, [2e-5; 3], "<collision><geometry><sphere radius='0.03'/></geometry></collision>"),
        side("left", 0.15),
        side("right", -0.15)
    );
    let motor = |name: &str, rate: f64| {
        format!(
            "[[motor]]\njoint = \"{name}\"\nkind = \"velocity\"\ntarget = [[0, 0], [1, {rate}]]\nkd = 0.5\nmax_effort = 1.5\n"
        )
    };
    let text = format!(
        "[[robot]]\nurdf = \"robot.urdf\"\nbase = \"floating\"\npose.position = [0, 0, {}]\n{FLOOR}{}{}",
        RADIUS + 1e-4,
        motor("left", 4.0),
        motor("right", 6.0)
    );
    let file = scene_of("caster", &urdf, &text);
    let [coarse, fine] = [1e-3, 1e-7].map(|tolerance| report(&file, &[], &[], Some(1.5), tolerance));
    assert!(coarse.method.crowd.steps < 10, "{}", coarse.method.crowd.steps);
    let off = apart(&coarse, &fine);
    assert!(off < 1e-3, "{off} m");
}

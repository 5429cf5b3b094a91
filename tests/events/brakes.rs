//! Blows on joints that friction holds: a small one is borne, a larger one makes the joint slip as far as its momentum takes it.

use crate::scene_files::{joint, report, scene_of};
use catena::prelude::Report;
use std::fmt::Write;

/// A cart of 1 kg with 1 N of dry friction on level rails, and on it a slider of 0.1 kg that meets its stop at this speed [m/s]: 1e-3 m before it at the start.
fn cart(speed: f64) -> Report {
    let inertial = |mass: f64| {
        format!("<inertial><mass value='{mass}'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>")
    };
    let robot = format!(
        "<link name='rails'/><link name='cart'>{}</link><link name='slider'>{}</link>\
         <joint name='drives' type='prismatic'><parent link='rails'/><child link='cart'/><axis xyz='1 0 0'/>\
         <limit lower='-9' upper='9' effort='0' velocity='0'/><dynamics friction='1'/></joint>\
         <joint name='slides' type='prismatic'><parent link='cart'/><child link='slider'/><axis xyz='1 0 0'/>\
         <limit lower='-9' upper='1e-3' effort='0' velocity='0'/></joint>",
        inertial(1.0),
        inertial(0.1)
    );
    let file = scene_of("brakes_cart", &robot, "[[robot]]\nurdf = \"robot.urdf\"\n");
    report(&file, &[], &[("slides", speed)], Some(1e-3 / speed + 0.2), 1e-3)
}

/// The number of events of a kind.
fn count(ended: &Report, kind: &str) -> usize {
    ended.events.list.iter().filter(|event| event.kind == kind).count()
}

#[test]
fn friction_bears_a_blow_after_which_a_cart_would_slide_by_less_than_can_matter_and_no_other() {
    // Both go on at u = 0.1 v/1.1, and friction stops them after 1.1 u²/2.
    for (speed, slips) in [(1e-4, false), (1e-3, false), (0.02, true), (1.0, true)] {
        let ended = cart(speed);
        let distance = 0.5 * (0.1_f64 * speed).powi(2) / 1.1;
        let (driven, rate) = joint(&ended, "drives");
        let counts = ["slip", "limit_impact"].map(|kind| count(&ended, kind));
        assert_eq!(counts, [usize::from(slips), 1], "at {speed} m/s");
        assert_eq!(rate, 0.0, "at {speed} m/s");
        // A tenth of the height of 1e-7 m that a tolerance of 1e-3 m leaves to impacts.
        let allowed = if slips { 1e-12 } else { 1e-8 };
        assert!((driven - distance).abs() <= allowed, "at {speed} m/s: {driven:e} m, expected {distance:e}");
        assert!(slips || distance <= 1e-8, "{distance:e} m");
        let energy = 0.5 * 0.1 * speed * speed;
        assert!(ended.energy.max_relative_error <= 1e-12, "{:e} of {energy:e} J", ended.energy.max_relative_error);
    }
}

#[test]
fn a_finger_that_meets_its_stop_on_an_arm_that_friction_holds_meets_it_once() {
    // Six links of 0.4 kg with hinges about y and x in turn that 5 N m hold, and a finger of 10 g on the last.
    let mut robot = "<link name='l0'/>".to_string();
    for number in 1..=7 {
        let finger = number == 7;
        let (mass, size, axis) =
            if finger { (0.01, 1e-6, "0 1 0") } else { (0.4, 1e-3, ["0 1 0", "1 0 0"][number % 2]) };
        let (limit, friction) = if finger { ("lower='-1' upper='0.01'", 0.0) } else { ("lower='-3' upper='3'", 5.0) };
        write!(
            robot,
            "<link name='l{number}'><inertial><origin xyz='0.02 0.01 0.05'/><mass value='{mass}'/>\
             <inertia ixx='{size}' iyy='{size}' izz='{size}' ixy='0' ixz='0' iyz='0'/></inertial></link>\
             <joint name='j{number}' type='revolute'><parent link='l{}'/><child link='l{number}'/><origin xyz='0.01 0 0.1'/>\
             <axis xyz='{axis}'/><limit {limit} effort='0' velocity='0'/><dynamics friction='{friction}'/></joint>",
            number - 1
        )
        .expect("text");
    }
    let file = scene_of("brakes_finger", &robot, "[[robot]]\nurdf = \"robot.urdf\"\n");
    let ended = report(&file, &[("j7", 0.00999)], &[("j7", 0.01)], Some(0.1), 1e-3);
    // The joints slipped ten times.
    assert_eq!(["limit_impact", "slip", "release"].map(|kind| count(&ended, kind)), [1, 0, 0]);
    let (at, _) = joint(&ended, "j7");
    assert_eq!(at, 0.01);
}

//! Bodies between two fingers of which one motor presses both: friction brakes what slips by the force of the motor, while contacts that hold keep the fingers
//! where they are.

use crate::scene_files::{report, scene_of};
use catena::report::{LinkReport, Report};

const FRICTION: f64 = 0.6;
/// The force of the motor, shared by both fingers (N).
const PRESS: f64 = 20.0;
/// Mass (kg) and width (m) of what is held.
const MASS: f64 = 0.2;
const WIDTH: f64 = 0.06;

/// A gripper of two wide fingers that a motor closes along y, and what it holds without gravity: a link of these moments of inertia [kg m²] and this
/// shape, with this velocity.
fn held(
    folder: &str,
    inertia: f64,
    shape: &str,
    velocity: &str,
    keys: &str,
    [duration, tolerance]: [f64; 2],
) -> Report {
    let finger = |name: &str| {
        format!(
            "<link name='{name}'><inertial><mass value='0.15'/><inertia ixx='1e-4' iyy='1e-4' izz='1e-4' ixy='0' ixz='0' iyz='0'/></inertial>\
             <collision><geometry><box size='0.2 0.02 0.2'/></geometry></collision></link>"
        )
    };
    let slide = |side: &str, y: f64, along: f64, follows: &str| {
        format!(
            "<joint name='{side}_slide' type='prismatic'><parent link='base'/><child link='{side}'/><origin xyz='0 {y} 0'/><axis xyz='0 {along} 0'/>\
             <limit lower='-0.05' upper='0.05' effort='100' velocity='9'/>{follows}</joint>"
        )
    };
    let place = 0.5 * WIDTH + 0.01;
    let gripper = ["<link name='base'/>".into(), finger("left"), finger("right"), slide("left", place, -1.0, "")];
    let gripper = gripper.concat() + &slide("right", -place, 1.0, "<mimic joint='left_slide'/>");
    let body = format!(
        "<robot name='box'><link name='box'><inertial><mass value='{MASS}'/><inertia ixx='{inertia}' iyy='{inertia}' izz='{inertia}' ixy='0' ixz='0' iyz='0'/>\
         </inertial><collision><geometry>{shape}</geometry></collision></link></robot>"
    );
    let scene = format!(
        "[scene]\ngravity = [0, 0, 0]\n[[robot]]\nurdf = \"robot.urdf\"\n\
         [[robot]]\nname = \"box\"\nurdf = \"box.urdf\"\nbase = \"floating\"\nvelocity = {velocity}\n\
         [[motor]]\njoint = \"r/left_slide\"\nkind = \"effort\"\ntarget = {PRESS}\n[contact]\npairs = \"all\"\nfriction = {FRICTION}\n{keys}\n"
    );
    let file = scene_of(folder, &gripper, &scene);
    std::fs::write(file.with_file_name("box.urdf"), body).expect("a box");
    let end = report(&file, &[], &[], Some(duration), tolerance);
    assert!(end.energy.max_relative_error < 1e-12, "{:?}", end.energy);
    assert!(end.warnings.is_empty(), "{:?}", end.warnings);
    end
}

fn body(report: &Report) -> &LinkReport {
    &report.links.iter().find(|(name, _)| name.starts_with("box")).expect("a link").1
}

#[test]
fn a_box_that_turns_between_fingers_about_a_corner_that_sticks_is_braked_by_the_friction_of_the_others() {
    // About the corner the moment of inertia is m a². The reaction of the corner is what keeps the middle on its circle, and the corner sticks.
    let (inertia, rate) = (0.5 * MASS * WIDTH * WIDTH, 5.0);
    let torque = FRICTION * 0.5 * PRESS * WIDTH * (2.0 + 2.0_f64.sqrt()) / 2.0;
    let brake = torque / (MASS * WIDTH * WIDTH);
    let shape = format!("<box size='{WIDTH} {WIDTH} {WIDTH}'/>");
    let speed = 0.5 * WIDTH * rate;
    let velocity = format!("{{ linear = [{speed}, 0, {}], angular = [0, {rate}, 0] }}", -speed);
    let stop = rate / brake;
    for (case, tolerance) in [1e-4, 1e-6, 1e-8].into_iter().enumerate() {
        let turning = |name: &str, duration: f64| {
            let folder = format!("turns_between_fingers_{name}_{case}");
            held(&folder, inertia, &shape, &velocity, "", [duration, tolerance])
        };
        let end = turning("and_slips", 0.7 * stop);
        let left = rate - 0.7 * stop * brake;
        let is = body(&end).angular_velocity[1];
        println!("{tolerance:e}: rate {is}, off by {:e}", is - left);
        assert!((is - left).abs() < 1e-8 * rate, "{tolerance:e}: {is} instead of {left} rad/s");
        let heat = 0.5 * MASS * WIDTH * WIDTH * (rate * rate - left * left);
        assert!(
            (end.energy.friction - heat).abs() < 1e-8 * heat,
            "{tolerance:e}: {} for {heat} J",
            end.energy.friction
        );
        let end = turning("and_stops", 2.0 * stop);
        let half = 0.5 * (0.5 * rate * stop);
        let [turned, wanted] = [body(&end).orientation[2], half.sin()];
        println!("{tolerance:e}: turned {turned}, off by {:e}", turned - wanted);
        assert!((turned - wanted).abs() < tolerance.max(1e-9), "{tolerance:e}: {turned} instead of {wanted}");
        assert_eq!(body(&end).angular_velocity, [0.0; 3], "{tolerance:e}");
    }
}

#[test]
fn a_ball_that_spins_between_fingers_is_braked_by_the_force_with_which_they_press() {
    // Spinning friction brakes at contacts that do not slip.
    let (inertia, rate, arm) = (0.4 * MASS * 0.25 * WIDTH * WIDTH, 5.0, 0.002);
    let brake = arm * PRESS / inertia;
    let shape = format!("<sphere radius='{}'/>", 0.5 * WIDTH);
    let velocity = format!("{{ linear = [0, 0, 0], angular = [0, {rate}, 0] }}");
    let keys = format!("spinning_friction = {arm}");
    let stop = rate / brake;
    let end = held("spins_between_fingers", inertia, &shape, &velocity, &keys, [0.7 * stop, 1e-8]);
    let is = body(&end).angular_velocity[1];
    assert!((is - 0.3 * rate).abs() < 1e-9 * rate, "{is} instead of {} rad/s", 0.3 * rate);
    let end = held("stops_between_fingers", inertia, &shape, &velocity, &keys, [2.0 * stop, 1e-8]);
    assert_eq!(body(&end).angular_velocity, [0.0; 3]);
}

#[test]
fn a_box_that_fingers_catch_in_flight_ends_held() {
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/parts");
    let scene = format!(
        "[[robot]]\nname = \"gripper\"\nurdf = \"{robots}/holding_gripper.urdf\"\npositions = {{ left_slide = 0.015, right_slide = 0.015 }}\n\
         velocities = {{ left_slide = 0.38286456943833214, right_slide = 0.38286456943833214 }}\n\
         [[robot]]\nname = \"box\"\nurdf = \"{robots}/held_box.urdf\"\nbase = \"floating\"\npose = {{ position = [0, 0, 0.03] }}\n\
         velocity = {{ linear = [-0.7095911718830923, 0.3686051157610263, 0.10188600247459279], angular = [0.1271314058560042, 0.11136822532087765, 0.11482714808122826] }}\n\
         [[motor]]\njoint = \"gripper/left_slide\"\nkind = \"effort\"\ntarget = {PRESS}\n[contact]\npairs = \"all\"\nfriction = {FRICTION}\n"
    );
    let file = scene_of("caught_in_flight", "", &scene);
    let places = [1e-4, 1e-6].map(|tolerance| {
        let end = report(&file, &[], &[], Some(0.15), tolerance);
        let LinkReport { position, orientation, linear_velocity, angular_velocity, .. } = *body(&end);
        println!("{tolerance:e}: {position:?}, {orientation:?}, {linear_velocity:?}, {angular_velocity:?}");
        let speeds = linear_velocity.iter().chain(&angular_velocity);
        assert!(speeds.fold(0.0_f64, |most, speed| most.max(speed.abs())) < 1e-9, "{tolerance:e}: it moves");
        // Four degrees: steps over all events of 0.1 ms have 4.2 degrees.
        assert!((orientation[2] + 0.034).abs() < 0.004, "{tolerance:e}: {orientation:?}");
        position
    });
    let apart = places[0].iter().zip(places[1]).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-4, "{apart:e}");
}

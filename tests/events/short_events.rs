//! Events that are short beside the steps of the motion: blows that graze a limit, slips under loads that hardly exceed friction, saturations of a
//! millisecond. None is missed, at any tolerance.

use crate::scene_files::{apart, joint, report, scene_of};
use catena::report::Report;
use std::f64::consts::PI;

/// A mass of 1 kg on a slide along x.
const SLIDE: &str = r#"<link name="f"/><link name="m"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="prismatic"><parent link="f"/><child link="m"/><axis xyz="1 0 0"/>
<limit lower="-50" upper="50" effort="0" velocity="0"/></joint>"#;

/// An arm of two links about y, each with its limits at ±3 rad.
const ARM: &str = r#"<link name="f"/><link name="u"><inertial><origin xyz="0.2 0 0"/><mass value="1.3"/>
<inertia ixx="0.01" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="s" type="revolute"><parent link="f"/><child link="u"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="0" velocity="0"/></joint>
<link name="l"><inertial><origin xyz="0.15 0 0"/><mass value="0.7"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="e" type="revolute"><parent link="u"/><child link="l"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="0" velocity="0"/></joint>"#;

fn run(folder: &str, robot: &str, scene: &str, duration: f64, tolerance: f64) -> Report {
    let file = scene_of(folder, robot, &format!("[[robot]]\nurdf = \"robot.urdf\"\n{scene}"));
    report(&file, &[], &[], Some(duration), tolerance)
}

fn counted(report: &Report, kind: &str) -> usize {
    report.events.list.iter().filter(|event| event.kind == kind).count()
}

#[test]
fn a_limit_that_a_vibration_grazes_is_met_each_time_it_passes() {
    let (rate, amplitude, restitution) = (2.0_f64, 0.31_f64, 0.8_f64);
    for depth in [1e-2, 1e-3, 1e-4, 1e-5] {
        let limit = amplitude * (1.0 - depth);
        // x = A cos θ with θ from −(π − α) to π − α between two blows, α = acos(limit/A).
        let free = |amplitude: f64| PI - (limit / amplitude).acos();
        let bounced =
            |amplitude: f64| (limit.powi(2) + restitution.powi(2) * (amplitude.powi(2) - limit.powi(2))).sqrt();
        let first = free(amplitude) / rate;
        let second = first + 2.0 * free(bounced(amplitude)) / rate;
        let last = bounced(bounced(amplitude));
        let duration = second + 0.65;
        let expected = last * (rate * 0.65 - free(last)).cos();
        for tolerance in [1e-3, 1e-4, 1e-6, 1e-9] {
            let scene = format!(
                "positions = {{ j = {amplitude} }}\n[[joint]]\nname = \"j\"\nlimit = [-{limit}, 50]\nrestitution = {restitution}\n\
                 [[spring]]\njoint = \"j\"\nstiffness = 4\n"
            );
            let end = run("grazed_limit", SLIDE, &scene, duration, tolerance);
            let blows = counted(&end, "limit_impact");
            let off = (joint(&end, "j").0 - expected).abs();
            assert_eq!(blows, 2, "depth {depth:e} at {tolerance:e} m: {off:e} m off");
            assert!(off <= tolerance, "depth {depth:e} at {tolerance:e} m: {off:e} m off");
        }
    }
}

#[test]
fn slips_of_milliseconds_under_a_load_that_hardly_exceeds_friction_begin_and_end_once_each() {
    let (friction, load, rate) = (1.7_f64, 1.70017_f64, 17.0_f64);
    let begins = (friction / load).asin() / rate;
    // It stops when the load has given as much momentum as friction has taken: by bisection.
    let momentum = |time: f64| load * ((rate * begins).cos() - (rate * time).cos()) / rate - friction * (time - begins);
    let (mut low, mut high) = (PI / (2.0 * rate) + 1e-4, PI / rate);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        (low, high) = if momentum(middle) > 0.0 { (middle, high) } else { (low, middle) };
    }
    // Mid-point rule: x = ∫ p dt over the slip.
    let (steps, span) = (100_000, low - begins);
    let slip: f64 = (0..steps).map(|i| momentum(begins + span * (f64::from(i) + 0.5) / f64::from(steps))).sum();
    let slip = slip * span / f64::from(steps);
    for tolerance in [1e-3, 1e-4, 1e-6, 1e-8] {
        let scene = "[[joint]]\nname = \"j\"\nfriction = 1.7\n[[load]]\njoint = \"j\"\neffort = 1\n\
                     factor = { formula = \"p*sin(w*t)\", p = 1.70017, w = 17 }\n";
        // One slip in every half-wave, to and fro: nine until then, of which one is left.
        let end = run("grazed_friction", SLIDE, scene, 1.7075480070099818, tolerance);
        assert_eq!((counted(&end, "slip"), counted(&end, "stick")), (9, 9), "{tolerance:e}");
        let off = (joint(&end, "j").0 - slip).abs();
        // Some roundings of the load, 4e-16 N, over the slip of 2.5 ms are a part of 1e-12 of its momentum.
        assert!(off < 1e-6 * slip, "{tolerance:e}: {off:e} of {slip:e} m");
        assert!(end.steps < 200, "{tolerance:e}: {} steps", end.steps);
    }
}

#[test]
fn slips_under_loads_that_are_quicker_than_steps_are_seen_at_every_tolerance() {
    let scene = "positions = { s = 1.319, e = 0.027 }\n[[joint]]\nname = \"s\"\nfriction = 0.681\n[[load]]\njoint = \"s\"\n\
                 effort = 0.7389\nfactor = { formula = \"sin(w*t+p)\", w = 19.52, p = 0.39 }\n[[joint]]\nname = \"e\"\n\
                 friction = 0.217\n[[load]]\njoint = \"e\"\neffort = 0.3015\nfactor = { formula = \"sin(w*t+p)\", w = 9.26, p = 1.41 }\n";
    let exact = run("quick_loads", ARM, scene, 2.5, 1e-10);
    // An event-driven DOP853 of the written-out equations has 34 events, too.
    assert_eq!((counted(&exact, "slip"), counted(&exact, "stick")), (17, 17));
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
        let end = run("quick_loads", ARM, scene, 2.5, tolerance);
        assert_eq!((counted(&end, "slip"), counted(&end, "stick")), (17, 17), "{tolerance:e}");
        let off = apart(&end, &exact);
        assert!(off <= tolerance, "{tolerance:e}: {off:e} m off");
    }
}

#[test]
fn a_box_that_is_lifted_off_while_next_to_nothing_pulls_it_aside_parts_with_all_its_corners_at_once() {
    // m z̈ = r t − m g from t₁ = m g/r on: z = z₀ + r (t − t₁)³/(6 m). The pull f r t reaches the cone f t₁/μ before t₁: the box slips for less time than a
    // step can be solved in. One corner was let go alone, and came back: reversals, sticks, and up to 10 ms in which the floor held the box, 5e-6 m.
    let (friction, duration) = (0.5, 0.8_f64);
    for lift in [20.0_f64, 35.0, 60.0] {
        let begins = 9.81 / lift;
        let expected = 0.1 + lift / 6.0 * (duration - begins).powi(3);
        for step in 0..16 {
            let pull = 10.0_f64.powf(-11.0 + 0.25 * f64::from(step));
            let scene = format!(
                "[contact]\nfriction = {friction}\n[[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\n\
                 [[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.2, 0.2, 0.2] }}\nmass = 1\n\
                 pose = {{ position = [0, 0, 0.1] }}\n\
                 [[load]]\nlink = \"box\"\nforce = [{pull}, 0, 1]\nfactor = [[0, 0], [1, {lift}]]\n"
            );
            let end = report(&scene_of("lifted_box", "", &scene), &[], &[], Some(duration), 1e-6);
            let off =
                (end.links.iter().find(|(name, _)| name == "box").expect("the box").1.position[2] - expected).abs();
            let parts: Vec<f64> = end
                .events
                .list
                .iter()
                .filter(|event| event.kind == "release")
                .map(|event| event.time - begins)
                .collect();
            println!("lift {lift} N/s, pull {pull:e}: {off:e} m, released {parts:?} s late");
            // The motion is exact for the scheme; steps that look away from their events, 1.6e-7 s, leave 1e-11 m.
            assert!(off <= 1e-10, "lift {lift} N/s, pull {pull:e}: {off:e} m");
            assert!(matches!(parts[..], [late] if late.abs() < 1e-6), "lift {lift} N/s, pull {pull:e}: {parts:?}");
        }
    }
}

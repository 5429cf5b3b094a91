//! Arms that hard motors hold: rates and efforts ring in steps that are longer than the time constants of their dampers, and the zeros that they pass are
//! no events.

use crate::common::scratch;
use crate::scene_files::{apart, joint, report, scene_of};
use catena::prelude::*;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A scene of a robot file, with a position motor with target 0 on each joint.
fn held(folder: &Path, urdf: &str, joints: usize, [kp, kd]: [f64; 2]) -> PathBuf {
    std::fs::write(folder.join("arm.urdf"), urdf).expect("a robot");
    let mut scene = "[[robot]]\nurdf = \"arm.urdf\"\n".to_string();
    for number in 0..joints {
        write!(scene, "[[motor]]\njoint = \"j{number}\"\nkind = \"position\"\ntarget = 0\nkp = {kp}\nkd = {kd}\nmax_effort = 1e6\n")
            .expect("text");
    }
    let file = folder.join("scene.toml");
    std::fs::write(&file, scene).expect("a scene");
    file
}

#[test]
fn joints_that_creep_against_hard_dampers_stop_and_slip_only_where_the_motion_does() {
    // Four links of 0.1 kg and 0.1 m, with hinges about y and z in turn, which have 0.1 N m of dry friction.
    let mut urdf = "<robot name=\"arm\"><link name=\"base\"/>".to_string();
    for number in 0..4 {
        let (parent, x) = if number == 0 { ("base".to_string(), 0.0) } else { (format!("l{}", number - 1), 0.1) };
        let axis = if number % 2 == 0 { "0 1 0" } else { "0 0 1" };
        write!(
            urdf,
            "<link name=\"l{number}\"><inertial><origin xyz=\"0.05 0 0.02\"/><mass value=\"0.1\"/>\
             <inertia ixx=\"1e-4\" iyy=\"1e-4\" izz=\"2e-5\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\
             <joint name=\"j{number}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"l{number}\"/><origin xyz=\"{x} 0 0\"/>\
             <axis xyz=\"{axis}\"/><limit lower=\"-2\" upper=\"2\" effort=\"0\" velocity=\"50\"/><dynamics friction=\"0.1\"/></joint>"
        )
        .expect("text");
    }
    urdf.push_str("</robot>");
    for [kp, kd] in [[1e4, 300.0], [1e5, 3000.0]] {
        let file = held(&scratch("hard_dampers_creep"), &urdf, 4, [kp, kd]);
        // Twenty time constants kd/kp.
        let ended = report(&file, &[], &[], Some(0.6), 1e-6);
        // The weights at 0.05 to 0.35 m, and at 0.05 and 0.15 m beyond the third hinge, less what friction holds. The arm sags by 7e-5 rad, which changes
        // these torques by 6e-6 N m.
        let weight = 0.1 * 9.81;
        for (name, lever) in [("j0", 0.8), ("j2", 0.2)] {
            let (expected, (found, _)) = ((weight * lever - 0.1) / kp, joint(&ended, name));
            assert!((found - expected).abs() <= 1e-5 / kp, "kp {kp}, {name}: {found:e}, expected {expected:e}");
        }
        let accuracy = ended.accuracy.as_ref().expect("an accuracy");
        assert!(accuracy.reached, "kp {kp}: {accuracy:?}");
        // 8000 and more before.
        let count = ended.events.counts.total();
        println!("kp {kp}: {count} events in {} steps, told {:e}", ended.steps, accuracy.estimated);
        assert!(count <= 40, "kp {kp}: {count} events");
        let warned = ended.warnings.iter().find(|warning| warning.contains("energy balance"));
        assert!(warned.is_none(), "kp {kp}: {warned:?}");
    }
}

#[test]
fn joints_on_limits_beside_hard_dampers_bear_their_loads_with_few_releases() {
    // Two of three joints start on their upper limits, on which weights press them.
    let mut urdf = "<robot name=\"arm\"><link name=\"base\"/>".to_string();
    let links = [
        ("base", "0.021 0.082 -0.006", "1 0 0", 0.0, 0.317, "0.083 -0.005 0.016"),
        ("l0", "0.028 -0.070 0.027", "1 0 0", 2.0, 0.298, "-0.006 0.067 -0.005"),
        ("l1", "0.052 0.018 -0.040", "0 0 1", 0.0, 0.441, "0.048 0.034 -0.087"),
    ];
    for (number, (parent, place, axis, upper, mass, center)) in links.iter().enumerate() {
        write!(
            urdf,
            "<link name=\"l{number}\"><inertial><origin xyz=\"{center}\"/><mass value=\"{mass}\"/>\
             <inertia ixx=\"1e-4\" iyy=\"1e-4\" izz=\"1e-4\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\
             <joint name=\"j{number}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"l{number}\"/><origin xyz=\"{place}\"/>\
             <axis xyz=\"{axis}\"/><limit lower=\"-2\" upper=\"{upper}\" effort=\"100\" velocity=\"50\"/></joint>"
        )
        .expect("text");
    }
    urdf.push_str("</robot>");
    let file = held(&scratch("hard_dampers_bear"), &urdf, 3, [1e5, 3000.0]);
    let ended = report(&file, &[], &[], Some(0.2), 1e-6);
    // Steps over events have dampers at their ends, and no event.
    let model = Model::load(&file).expect("a model");
    let mut over_events = Simulation::new(&model).fixed(1, 2e-5).duration(0.2);
    over_events.run().expect("a run");
    let over_events = over_events.finish().expect("a report");
    let (off, count) = (apart(&ended, &over_events), ended.events.counts.total());
    println!("{count} events in {} steps, {off:e} m apart", ended.steps);
    // Steps of first order are off by their length times the rates of 1e-5 rad/s that decay in 0.03 s.
    assert!(off <= 1e-9, "{off:e} m apart");
    // 1606 before, 136 now: a step that is shorter than ten time constants resolves what rings, and meets its events.
    assert!(count <= 300, "{count} events");
}

#[test]
fn an_impact_in_the_first_step_after_a_corner_of_a_target_has_no_part_of_a_transient() {
    // At 0.3 s the target stops to change, and a damper of 2000 1/s stops the rate of the last hinge. The second link strikes the floor 0.073 s later:
    // steps are longer, and a run and a coarser one both went there in one step, with the same error of the rate, 1e-3 rad/s.
    let links = [
        ("0 0 0", 3.5, [0.018, 0.023, 0.015], ""),
        (
            "0 0 0",
            0.2,
            [8.3e-4, 5.4e-4, 1.1e-3],
            "<collision><geometry><box size=\"0.16 0.2 0.089\"/></geometry></collision>",
        ),
        ("0 0 0", 0.31, [1.3e-3, 9.5e-4, 7.3e-4], ""),
        ("-0.032 0.031 -0.016", 1.2, [9.3e-4; 3], ""),
    ];
    let joints = [
        ("0.13 0.25 -0.19", "-0.01 -0.15 0.65", "1 0 0", 0.0),
        ("0.19 -0.19 0.2", "-0.28 0.47 0.47", "0.84 0.0091 -0.51", 0.39),
        ("0.24 0.12 0.047", "-0.064 -0.98 0.76", "-0.063 -0.31 0.57", 0.0),
    ];
    let mut urdf = String::new();
    for (number, (center, mass, [x, y, z], shape)) in links.iter().enumerate() {
        write!(
            urdf,
            "<link name=\"l{number}\"><inertial><origin xyz=\"{center}\"/><mass value=\"{mass}\"/>\
             <inertia ixx=\"{x}\" iyy=\"{y}\" izz=\"{z}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{shape}</link>"
        )
        .expect("text");
    }
    for (number, (place, turn, axis, damping)) in joints.iter().enumerate() {
        let next = number + 1;
        write!(
            urdf,
            "<joint name=\"j{next}\" type=\"continuous\"><parent link=\"l{number}\"/><child link=\"l{next}\"/>\
             <origin xyz=\"{place}\" rpy=\"{turn}\"/><axis xyz=\"{axis}\"/><dynamics damping=\"{damping}\"/></joint>"
        )
        .expect("text");
    }
    let scene = "[[robot]]\nurdf = \"robot.urdf\"\nbase = \"floating\"\npose = { position = [0, 0, 1.3], rpy = [-0.46, -0.42, -0.24] }\n\
         velocity = { linear = [-0.18, 0.016, -1.2], angular = [1.1, -1, 1.7] }\npositions = { j1 = 0.24, j2 = 0.44, j3 = 0.63 }\n\
         velocities = { j1 = 0.17, j2 = -0.6 }\n[[motor]]\njoint = \"j3\"\nkind = \"velocity\"\ntarget = [[0, -0.38], [0.15, 0.6], [0.3, -1.5]]\n\
         interpolation = \"cubic\"\nkd = 1.8\nmax_effort = 1.4\n[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n\
         [contact]\nself_contact = false\nfriction = 0.55\nrestitution = 0.49\n";
    let file = scene_of("hard_dampers_corner", &urdf, scene);
    let [ended, closer] = [1e-6, 1e-9].map(|tolerance| report(&file, &[], &[], Some(0.5), tolerance));
    let (off, accuracy) = (apart(&ended, &closer), ended.accuracy.as_ref().expect("an accuracy"));
    println!("{off:e} m apart, told {:e}", accuracy.estimated);
    assert!(accuracy.reached, "{accuracy:?}");
    // 8.8e-6 m before, told 9e-10 m.
    assert!(off <= 1e-6, "{off:e} m");
}

#[test]
fn a_joint_that_leaves_its_limit_is_not_put_back_on_it_where_a_long_step_is_roughly_known() {
    // A finger of three links on an arm of two, all on their limits.
    let links = [
        ("-0.0588 -0.0573 0.0199", 0.885, 0.00885, "0 0 1", [-9.0, 9.0], "damping='0'"),
        ("0.0299 -0.0547 -0.0249", 1.04, 0.0104, "0 0 1", [-9.0, 9.0], "damping='0' friction='1'"),
        ("-0.0574 0.0864 0.0933", 0.0123, 3.94e-4, "0 0 1", [0.0, 1.5], "damping='0.228'"),
        ("-0.058 -0.041 -0.0142", 0.0107, 3.67e-5, "1 0 0", [0.0, 1.5], "damping='0.0142'"),
        ("0.0823 -0.0577 -0.0614", 0.0197, 8.6e-5, "0 1 0", [0.0, 1.5], "damping='0.635'"),
    ];
    let mut robot = "<link name='l0'/>".to_string();
    for (number, (at, mass, size, axis, [lower, upper], dynamics)) in links.into_iter().enumerate() {
        write!(
            robot,
            "<link name='l{1}'><inertial><origin xyz='{at}'/><mass value='{mass}'/>\
             <inertia ixx='{size}' iyy='{size}' izz='{size}' ixy='0' ixz='0' iyz='0'/></inertial></link>\
             <joint name='j{1}' type='revolute'><parent link='l{0}'/><child link='l{1}'/><origin xyz='{at}'/><axis xyz='{axis}'/>\
             <limit lower='{lower}' upper='{upper}' effort='9' velocity='9'/><dynamics {dynamics}/></joint>",
            number,
            number + 1
        )
        .expect("text");
    }
    let file = scene_of("hard_dampers_leaving", &robot, "[[robot]]\nurdf = \"robot.urdf\"\n");
    let ended = report(&file, &[], &[], Some(1.0), 1e-3);
    let off = apart(&ended, &report(&file, &[], &[], Some(1.0), 1e-7));
    println!("{} steps, off {off:e} m", ended.steps);
    // A joint that left its limit at 1e-7 rad/s was put back on it 280 times, each time 1e-11 s later.
    assert!(ended.steps <= 120 && off <= 1e-3, "{} steps, off {off:e} m", ended.steps);
}

#[test]
fn a_limit_lets_go_of_an_arm_at_its_instant_though_its_force_rings_through_zero_earlier_in_the_step() {
    // Points of mass on two hinges, a slide and a hinge with a damper of 1e-5 s. Three stages in steps of 0.2 and of 0.05 ms say 0.8301 s, and agree to 3e-13 m.
    let link = |name: &str, x: f64, mass: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='{x} 0 0'/><mass value='{mass}'/>\
             <inertia ixx='0' iyy='0' izz='0' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let joint = |number: usize, kind: &str, x: f64, axis: &str, [lower, upper]: [f64; 2], damping: f64| {
        format!(
            "<joint name='j{number}' type='{kind}'><parent link='l{}'/><child link='l{number}'/><origin xyz='{x} 0 0'/><axis xyz='{axis}'/>\
             <limit lower='{lower}' upper='{upper}' effort='0' velocity='0'/><dynamics damping='{damping}'/></joint>",
            number - 1
        )
    };
    let wide = [-50.0, 50.0];
    let robot = [
        "<link name='l0'/>".to_string(),
        link("l1", 0.0, 0.06),
        link("l2", 0.0, 0.05),
        link("l3", 0.0, 0.63058),
        link("l4", 0.3, 0.1208),
        joint(1, "revolute", 0.0, "0 1 0", [-0.6, 0.6087], 0.0),
        joint(2, "revolute", 0.2, "0 1 0", wide, 0.0),
        joint(3, "prismatic", 0.0, "0 0 1", wide, 0.0),
        joint(4, "revolute", 0.6, "0 0 1", wide, 2143.1),
    ];
    let text = "[[robot]]\nurdf = \"robot.urdf\"\npositions = { j1 = 0.014, j2 = -0.0078, j3 = -0.0164, j4 = -0.0148 }\n\
                velocities = { j1 = 1.811, j2 = -2.095, j4 = 2.197 }\n\
                [[spring]]\njoint = \"j2\"\nstiffness = 6.449\nrest = 0.008\ndamping = 0.0078877\n\
                [[spring]]\njoint = \"j3\"\nstiffness = 256.34\nrest = -0.206\ndamping = 9.5434\n";
    let file = scene_of("hard_dampers_lets_go", &robot.concat(), text);
    for tolerance in [1e-3, 1e-4, 1e-6, 1e-7] {
        let ended = report(&file, &[], &[], Some(1.0), tolerance);
        let releases: Vec<f64> =
            ended.events.list.iter().filter(|event| event.kind == "release").map(|event| event.time).collect();
        println!("{tolerance:e}: {releases:?} in {} steps", ended.steps);
        // It was 0.8494 s, and the end 7e-3 m off, told 4e-10 m.
        assert!(releases.len() == 1 && (releases[0] - 0.8301).abs() < 1e-3, "{tolerance:e} m: {releases:?}");
    }
}

#[test]
fn hard_dampers_leave_rates_within_the_tolerance_in_a_second_and_ask_for_no_short_steps() {
    // A slide along x and a hinge about x behind it, with time constants of 2e-6 s and 4e-8 s, and springs that they creep to. Masses in kg, places in m.
    let link = |name: &str, mass: f64, below: f64, inertia: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0 0 -{below}'/><mass value='{mass}'/>\
             <inertia ixx='{inertia}' iyy='{inertia}' izz='{inertia}' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let joint = |number: usize, kind: &str, damping: f64| {
        format!(
            "<joint name='j{number}' type='{kind}'><parent link='l{}'/><child link='l{number}'/><axis xyz='1 0 0'/>\
             <limit lower='-9' upper='9' effort='9' velocity='9'/><dynamics damping='{damping}'/></joint>",
            number - 1
        )
    };
    let ([slide, hinge], mass, below) = ([1.38e6, 3.73e6], 1.9, 0.23);
    let robot = [
        "<link name='l0'/>".to_string(),
        link("l1", 0.47, 0.12, 0.003),
        link("l2", mass, below, 0.05),
        joint(1, "prismatic", slide),
        joint(2, "revolute", hinge),
    ];
    let text = "[[robot]]\nurdf = \"robot.urdf\"\npositions = { j1 = -0.46, j2 = 0.2 }\n\
                [[spring]]\njoint = \"j1\"\nstiffness = 1670\nrest = -0.84\n[[spring]]\njoint = \"j2\"\nstiffness = 9.4e5\nrest = 0.4\n";
    let file = scene_of("hard_dampers_creep_to_springs", &robot.concat(), text);
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-6] {
        let ended = report(&file, &[], &[], Some(0.5), tolerance);
        let [(one, its), (other, rate)] = ["j1", "j2"].map(|name| crate::scene_files::joint(&ended, name));
        // Nothing accelerates.
        let expected = (9.4e5 * (0.4 - other) - mass * 9.81 * below * other.sin()) / hinge;
        let off = (rate - expected).abs().max((its - 1670.0 * (-0.84 - one) / slide).abs());
        println!("{tolerance:e}: {} steps, rates off by {off:e}", ended.steps);
        // Over a million steps at the finer three, and rates off by 0.1 rad/s at the first.
        assert!(ended.steps <= 200 && off <= tolerance, "{tolerance:e} m: {} steps, off by {off:e}", ended.steps);
        assert!(ended.warnings.is_empty(), "{tolerance:e} m: {:?}", ended.warnings);
    }
}

#[test]
fn sliders_behind_each_other_slip_stop_and_turn_at_their_instants_beside_damped_ones() {
    // Each row: mass (kg), stiffness (N/m), damping (N s/m), friction (N) and start (m) of sliders along x, each on the one before.
    let rows: [&[[f64; 5]]; 3] = [
        // The second stops at 0.44 s and slips at 0.495 s.
        &[
            [0.237, 41.32, 15.96, 0.4197, 0.246],
            [0.431, 13.48, 0.362, 0.2475, -0.157],
            [2.403, 6.884, 0.0, 0.2894, -0.023],
        ],
        // The first turns within the transient of the second.
        &[[3.0, 28.84, 1.776, 0.4265, 0.103], [6.166, 44.17, 115.2, 0.3596, -0.226]],
        // The second stops at 0.539 s, in the middle of a long step, and slips 3 ms later.
        &[
            [0.393, 3211.0, 1487.0, 0.0, 0.212],
            [0.509, 61.96, 8.552, 0.4278, -0.217],
            [0.603, 5917.0, 0.0, 202.6, 0.139],
        ],
    ];
    for (row, sliders) in rows.into_iter().enumerate() {
        let mut robot = "<link name='l0'/>".to_string();
        let (mut places, mut springs) = (String::new(), String::new());
        for (before, [mass, stiffness, damping, friction, start]) in sliders.iter().enumerate() {
            let number = before + 1;
            write!(
                robot,
                "<link name='l{number}'><inertial><mass value='{mass}'/>\
                 <inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial></link>\
                 <joint name='j{number}' type='prismatic'><parent link='l{before}'/><child link='l{number}'/><axis xyz='1 0 0'/>\
                 <limit lower='-9' upper='9' effort='9' velocity='9'/><dynamics damping='{damping}' friction='{friction}'/></joint>"
            )
            .expect("text");
            write!(places, "j{number} = {start}, ").expect("text");
            write!(springs, "[[spring]]\njoint = \"j{number}\"\nstiffness = {stiffness}\nrest = 0\n").expect("text");
        }
        let text = format!("[[robot]]\nurdf = \"robot.urdf\"\npositions = {{ {places} }}\n{springs}");
        let file = scene_of(&format!("hard_dampers_sliders_{row}"), &robot, &text);
        // Five stages in steps of 0.1 ms, which no transient here is shorter than.
        let model = Model::load(&file).expect("a model");
        let mut literal = Simulation::new(&model).fixed(5, 1e-4).duration(1.0);
        literal.run().expect("a run");
        let literal = literal.finish().expect("a report");
        for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8] {
            let ended = report(&file, &[], &[], Some(1.0), tolerance);
            let off = apart(&ended, &literal);
            println!("row {row}, {tolerance:e}: {} steps, off {off:e} m", ended.steps);
            // 2e-5 to 9e-5 m at 1e-6 or 1e-5 m.
            assert!(off <= tolerance, "row {row}, {tolerance:e} m: off {off:e} m");
        }
    }
}

/// Two sliders along x, the second on the first, with a damper between them (N s/m), and friction of the first (N). It is at rest at zero, or comes to its upper limit with 1 m/s, and
/// the other likewise.
fn two_sliders(folder: &str, [one, other]: [f64; 2], damping: f64, friction: f64, text: &str) -> PathBuf {
    let slider = |number: usize, mass: f64, limit: f64, dynamics: String| {
        format!(
            "<link name='l{number}'><inertial><mass value='{mass}'/><inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial></link>\
             <joint name='j{number}' type='prismatic'><parent link='l{}'/><child link='l{number}'/><axis xyz='1 0 0'/>\
             <limit lower='-9' upper='{limit}' effort='9' velocity='9'/><dynamics {dynamics}/></joint>",
            number - 1
        )
    };
    let first = slider(1, one, if friction == 0.0 { 0.1 } else { 9.0 }, format!("damping='0' friction='{friction}'"));
    let robot = ["<link name='l0'/>".to_string(), first, slider(2, other, 50.0, format!("damping='{damping}'"))];
    scene_of(folder, &robot.concat(), text)
}

#[test]
fn a_rebound_that_a_hard_damper_slows_down_at_once_is_no_rest() {
    for (number, ([one, other], restitution, damping)) in
        [([1.0, 0.5], 0.9, 1e8), ([1.0, 0.3], 0.5, 1e8), ([2.0, 0.3], 0.5, 1e6), ([1.0, 0.85], 0.9, 1e6)]
            .into_iter()
            .enumerate()
    {
        let text = format!(
            "[[robot]]\nurdf = \"robot.urdf\"\nvelocities = {{ j1 = 1 }}\n[[joint]]\nname = \"j1\"\nrestitution = {restitution}\n"
        );
        let file = two_sliders(&format!("hard_dampers_rebound_{number}"), [one, other], damping, 0.0, &text);
        // After 0.1 s the first rebounds, and both go on together with what their momenta leave.
        let expected = 0.1 + 0.2 * (other - restitution * one) / (one + other);
        for tolerance in [1e-2, 1e-3, 1e-4, 1e-6, 1e-8] {
            let ended = report(&file, &[], &[], Some(0.3), tolerance);
            let (off, count) = ((joint(&ended, "j1").0 - expected).abs(), ended.events.counts.total());
            println!("{number}, {tolerance:e}: off {off:e} m, {} steps, {count} events", ended.steps);
            // The other moves on by its rate times the time constant of 1e-9 to 3e-7 s. 0.005 to 0.06 m, told 1e-8 m, at 1e-2 m and some at 1e-4 m.
            assert!(off <= 5e-7 && count == 1, "{number}, {tolerance:e} m: off {off:e} m, {count} events");
        }
    }
}

#[test]
fn friction_slips_by_the_blow_of_a_hard_damper_and_stops_where_the_momentum_is_spent() {
    for (number, (masses, damping)) in [([1.0, 0.1], 1e8), ([2.0, 0.7], 1e6), ([0.5, 1.0], 1e5)].into_iter().enumerate()
    {
        let text = "[[robot]]\nurdf = \"robot.urdf\"\nvelocities = { j2 = 1 }\n";
        let file = two_sliders(&format!("hard_dampers_blow_{number}"), masses, damping, 1.0, text);
        // The centre of mass goes on by P²/(2 M) against 1 N, and the second by P/c on the first.
        let [one, other] = masses;
        let expected = other * other / (one + other) * (0.5 - 1.0 / damping);
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-7, 1e-8] {
            let ended = report(&file, &[], &[], Some(1.5), tolerance);
            let off = (joint(&ended, "j1").0 - expected).abs();
            println!("{number}, {tolerance:e}: off {off:e} m, {} steps", ended.steps);
            // A million steps, and not done in 20 s, at 1e-6 m and less.
            assert!(
                off <= tolerance && ended.steps <= 2000,
                "{number}, {tolerance:e} m: off {off:e} m, {} steps",
                ended.steps
            );
        }
    }
}

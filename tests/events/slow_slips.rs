//! Slips that are slow and change often, as of feet of a robot that shifts its weight: steps over slips keep to the tolerance there.

use crate::common::scratch;
use crate::scene_files::{apart, report, scene_of};
use std::fmt::Write;
use std::path::PathBuf;

/// The quadruped that stands after a fall from 5 cm, and from 1 s on other efforts of up to 1 N m in all its joints every 20 ms.
fn shifting_quadruped() -> PathBuf {
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/robots");
    let scene = std::fs::read_to_string(format!("{robots}/quadruped_dropped.toml")).expect("the scene");
    let mut text = scene.replace("parts/", &format!("{robots}/parts/"));
    let mut seed = 29_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    for leg in ["front_left", "front_right", "rear_left", "rear_right"] {
        for joint in ["hip", "knee"] {
            let efforts = (0..20).map(|change| format!(", [{}, {}]", 1.0 + 0.02 * f64::from(change), random()));
            let efforts: String = efforts.collect();
            writeln!(
                text,
                "[[load]]\njoint = \"{leg}_{joint}\"\neffort = 1.0\ninterpolation = \"hold\"\nfactor = [[0, 0]{efforts}]"
            )
            .expect("text");
        }
    }
    let file = scratch("shifting_quadruped").join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

#[test]
fn feet_that_creep_under_efforts_that_jump_are_followed_in_few_steps_within_the_tolerance() {
    let file = shifting_quadruped();
    let run = |tolerance: f64| report(&file, &[], &[], Some(1.3), tolerance);
    let (usual, fine) = (run(1e-4), run(1e-5));
    let accuracy = usual.accuracy.as_ref().expect("an accuracy");
    let (off, over_slips) = (apart(&usual, &fine), usual.method.over_slips);
    println!("{} steps, {over_slips:?}, off by {off:e}, told {:e}", usual.steps, accuracy.estimated);
    assert!(over_slips.steps > 100 && over_slips.order == 2, "{over_slips:?}");
    // 1728 steps without them: slips of 1e-6 m/s turn within 1e-4 s.
    assert!(usual.steps < 1100, "{} steps", usual.steps);
    // The finer run has an error of its own: which feet slip is not unique.
    let told = accuracy.estimated + fine.accuracy.as_ref().expect("an accuracy").estimated;
    assert!(accuracy.reached && off <= told, "told {told:e}, off by {off:e}");
    assert!(usual.method.crowd.time_share < 0.5 * over_slips.time_share, "{:?}", usual.method.crowd);
    assert!(usual.contact.max_penetration <= 1e-9, "{:e}", usual.contact.max_penetration);
}

#[test]
fn a_wall_that_rests_leaves_what_swings_beside_it_to_exact_steps_at_every_tolerance() {
    // 104 contacts rest; a ball that touches nothing until 0.45 s swings beside them.
    let robot = "<link name='base'/><link name='ball'><inertial><origin xyz='0 0 -1'/><mass value='3'/>\
        <inertia ixx='0.02' ixy='0' ixz='0' iyy='0.02' iyz='0' izz='0.02'/></inertial></link>\
        <joint name='swing' type='continuous'><origin xyz='0 0 1.4'/><parent link='base'/><child link='ball'/><axis xyz='0 1 0'/></joint>";
    let text = "[[robot]]\nurdf = \"robot.urdf\"\npositions = { swing = \"70 deg\" }\n\
        [[body]]\nname = \"brick\"\nshape = { type = \"box\", size = [0.1, 0.3, 0.15] }\ndensity = 1500\ngrid = [1, 3, 4]\nspacing = [1, 0.3, 0.15]\n\
        pose = { position = [3.0, -0.3, 0.075] }\n[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n";
    let file = crate::scene_files::scene_of("swing_beside_wall", robot, text);
    let runs = [1e-6, 1e-8].map(|tolerance| report(&file, &[], &[], Some(0.2), tolerance));
    for run in &runs {
        assert!(run.method.crowd.steps == 0 && run.steps < 10, "{:?} of {} steps", run.method.crowd, run.steps);
    }
    let off = apart(&runs[0], &runs[1]);
    assert!(off <= 1e-8, "{off:e}");
}

/// A chain of eleven small links that lies on a table from this place on (m) and hangs over its edge: 28 of its corners rest on the table, and one link turns about the edge.
fn chain_over_an_edge(name: &str, start: f64) -> PathBuf {
    let mut robot = String::new();
    for link in 0..11 {
        write!(
            robot,
            "<link name='l{link}'><inertial><origin xyz='0.03 0 0'/><mass value='0.02'/>\
             <inertia ixx='1e-6' iyy='4e-6' izz='4e-6' ixy='0' ixz='0' iyz='0'/></inertial>\
             <collision><origin xyz='0.03 0 0'/><geometry><box size='0.048 0.02 0.01'/></geometry></collision></link>"
        )
        .expect("text");
    }
    for link in 1..11 {
        let parent = link - 1;
        write!(
            robot,
            "<joint name='j{link}' type='continuous'><parent link='l{parent}'/><child link='l{link}'/>\
             <origin xyz='0.06 0 0'/><axis xyz='0 1 0'/></joint>"
        )
        .expect("text");
    }
    let text = format!(
        "[[robot]]\nurdf = \"robot.urdf\"\nbase = \"floating\"\npose = {{ position = [{start}, 0, 0.505] }}\n\
         [[obstacle]]\nname = \"table\"\nshape = {{ type = \"box\", size = [2, 1, 1] }}\n\
         pose = {{ position = [-1, 0, 0] }}\n[contact]\nfriction = 0.3\n"
    );
    scene_of(name, &robot, &text)
}

#[test]
fn many_contacts_that_share_their_loads_beside_one_that_slides_are_left_to_cheaper_steps_that_keep_to_the_tolerance() {
    let file = chain_over_an_edge("chain_over_an_edge", -0.562_338_598_036_213_4);
    let runs = [1e-3, 1e-4, 1e-6].map(|tolerance| report(&file, &[], &[], Some(0.04), tolerance));
    for (run, tolerance) in runs.iter().zip([1e-3, 1e-4, 1e-6]) {
        let exact = run.steps - run.method.crowd.steps - run.method.over_slips.steps;
        let (accuracy, off) = (run.accuracy.as_ref().expect("an accuracy"), apart(run, &runs[2]));
        println!("{tolerance:e}: {exact} of {} steps, off by {off:e}, told {:e}", run.steps, accuracy.estimated);
        // An exact step takes fifteen iterations of nine stages with 34 contacts, and as much time as a thousand of the others; there were 350 of them.
        assert!(exact <= 40, "{exact} of {} steps at {tolerance:e}", run.steps);
        assert!(off <= tolerance && accuracy.estimated <= tolerance, "off by {off:e}, told {:e}", accuracy.estimated);
    }
}

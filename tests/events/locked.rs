//! A joint whose limits leave one position moves as a fixed one: in trees and loops, with impacts, and if it follows another joint.

use crate::common::{scratch, shared};
use crate::scene_files::{apart, joint, report};
use catena::report::Report;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Positions of links at the end are the same to this (m): both runs have the tolerance 1e-9, and the steps of the same motion, but roundings of 1e-16 in
/// the composed masses grow with impacts, a factor of about 10 each.
const SAME: f64 = 1e-10;

/// Random numbers: a linear congruential generator, so that each run of the test is the same.
struct Random(u64);

impl Random {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }

    fn vector(&mut self, size: f64) -> [f64; 3] {
        [(); 3].map(|()| self.within(-size, size))
    }
}

fn words(numbers: [f64; 3]) -> String {
    format!("{} {} {}", numbers[0], numbers[1], numbers[2])
}

/// How the joint in the middle is held.
#[derive(Clone, Copy, PartialEq)]
enum Held {
    Fixed,
    /// Its own limits coincide.
    Limits,
    /// It follows a joint beside the chain, whose limits and its own leave one position.
    Follower,
}

/// A chain of four links, of which the third is held at a place; the first joint runs into its limit.
fn chain(folder: &Path, seed: u64, slides: bool, closed: bool, held: Held) -> PathBuf {
    let mut random = Random(seed);
    let mut urdf = String::from("<robot name='r'><link name='base'/>");
    let place = random.within(-0.3, 0.3);
    for index in 0..4 {
        let parent = if index == 0 { "base".to_string() } else { format!("l{}", index - 1) };
        let (center, axis, at) = (random.vector(0.1), random.vector(1.0), random.vector(0.2));
        let moments = [(); 3].map(|()| random.within(0.01, 0.015));
        let mass = random.within(0.5, 1.5);
        write!(
            urdf,
            "<link name='l{index}'><inertial><origin xyz='{}'/><mass value='{mass}'/><inertia ixx='{}' iyy='{}' izz='{}' \
             ixy='0' ixz='0' iyz='0'/></inertial></link>",
            words(center),
            moments[0],
            moments[1],
            moments[2]
        )
        .expect("text");
        let origin = words(at);
        if index != 2 {
            let axis = words(axis);
            write!(
                urdf,
                "<joint name='j{index}' type='continuous'><parent link='{parent}'/><child link='l{index}'/>\
                 <origin xyz='{origin}'/><axis xyz='{axis}'/></joint>"
            )
            .expect("text");
            continue;
        }
        // Along x, so that the displacement of the fixed one is written exactly.
        let (kind, moved) = match (slides, held == Held::Fixed) {
            (true, true) => ("fixed", format!("<origin xyz='{} {} {}'/>", at[0] + place, at[1], at[2])),
            (false, true) => ("fixed", format!("<origin xyz='{origin}' rpy='{place} 0 0'/>")),
            (true, false) => ("prismatic", format!("<origin xyz='{origin}'/>")),
            (false, false) => ("revolute", format!("<origin xyz='{origin}'/>")),
        };
        let limit = match held {
            Held::Fixed => String::new(),
            Held::Limits => format!("<limit effort='1' velocity='1000' lower='{place}' upper='{place}'/>"),
            // The leader is at least at 0.2, and this joint at most at the place.
            Held::Follower => format!(
                "<limit effort='1' velocity='1000' lower='-2' upper='{place}'/><mimic joint='side' multiplier='2' offset='{}'/>",
                place - 0.4
            ),
        };
        write!(
            urdf,
            "<joint name='j2' type='{kind}'><parent link='{parent}'/><child link='l2'/>{moved}<axis xyz='1 0 0'/>{limit}</joint>"
        )
        .expect("text");
    }
    // The leader turns a ball about its centre, so that its place changes no motion.
    let (kind, limit) = if held == Held::Follower {
        ("revolute", "<limit effort='1' velocity='1000' lower='0.2' upper='2'/>")
    } else {
        ("fixed", "")
    };
    write!(
        urdf,
        "<link name='ball'><inertial><mass value='0.1'/><inertia ixx='1e-3' iyy='1e-3' izz='1e-3' ixy='0' ixz='0' iyz='0'/>\
         </inertial></link><joint name='side' type='{kind}'><parent link='l0'/><child link='ball'/><origin xyz='0 0.1 0'/>\
         <axis xyz='0 0 1'/>{limit}</joint></robot>"
    )
    .expect("text");
    let mut scene = String::from("[[robot]]\nname = \"r\"\nurdf = \"r.urdf\"\nvelocities = { j0 = 3.0, j3 = -2.0 }\n");
    scene +=
        "[[joint]]\nname = \"j0\"\nlimit = [-0.5, 0.2]\nrestitution = 0.6\n[[joint]]\nname = \"j1\"\nfriction = 0.05\n";
    if closed {
        scene += "[[loop]]\ntype = \"distance\"\na = { link = \"l3\", position = [0.1, 0.05, 0] }\n";
        scene += "b = { link = \"world\", position = [0.7, 0.6, 0.5] }\nlength = 0.9\n";
    }
    std::fs::write(folder.join("r.urdf"), urdf).expect("a URDF");
    let file = folder.join("scene.toml");
    std::fs::write(&file, scene).expect("a scene");
    file
}

fn assert_same(what: &str, found: &Report, fixed: &Report) {
    let distance = apart(found, fixed);
    assert!(distance <= SAME, "{what}: {distance:e} m");
    let energies = [(found.energy.initial, fixed.energy.initial), (found.energy.impacts, fixed.energy.impacts)];
    for (found, wanted) in energies {
        // Joules of a robot of some kilograms and metres per second.
        assert!((found - wanted).abs() <= 1e-9, "{what}: {found} J, not {wanted} J");
    }
}

#[test]
fn a_joint_whose_limits_coincide_moves_as_a_fixed_one_in_trees_and_loops_with_impacts() {
    let folder = scratch("random");
    for seed in 1..=6 {
        for (slides, closed) in [(false, false), (true, false), (false, true), (true, true)] {
            let run = |held: Held| {
                let file = chain(&folder, seed, slides, closed, held);
                report(&file, &[], &[], Some(0.6), 1e-9)
            };
            let fixed = run(Held::Fixed);
            let impacts = fixed.energy.impacts;
            assert!(closed || impacts > 0.0, "seed {seed}: the first joint runs into its limit");
            for (held, name) in [(Held::Limits, "limits"), (Held::Follower, "follower")] {
                assert_same(&format!("seed {seed}, slides {slides}, closed {closed}, {name}"), &run(held), &fixed);
            }
        }
    }
}

#[test]
fn a_locked_finger_on_an_arm_that_strikes_its_limit_keeps_the_energy_of_a_fixed_one() {
    let Some(folder) = shared("repro/events") else { return };
    let found = report(&folder.join("pin3.toml"), &[], &[], Some(0.5), 1e-9);
    let (elbow, _) = joint(&found, "elbow");
    // `fix3.urdf`, to the digits that are given for it.
    assert!((elbow - 3.29525).abs() < 5e-6, "{elbow}");
    assert!(found.energy.max_relative_error < 1e-9, "{:e}", found.energy.max_relative_error);
    assert_eq!(joint(&found, "finger"), (0.0, 0.0));
    let (_, finger) = found.joints.iter().find(|(name, _)| name == "finger").expect("a finger");
    let status = finger.status.as_ref().expect("a status");
    assert_eq!(status.limit, Some("lower"));
    // The limit carries the whole effort along the axis: the same as the torque of the weld.
    assert!(finger.reaction_torque[1].abs() > 1e-3, "{:?}", finger.reaction_torque);
}

#[test]
fn a_locked_joint_beside_a_loop_takes_no_part_in_closing_the_velocities_of_the_start() {
    let Some(folder) = shared("repro/events") else { return };
    let found = report(&folder.join("lock.toml"), &[], &[], None, 1e-9);
    let fixed = report(&folder.join("fixed.toml"), &[], &[], None, 1e-9);
    assert!((joint(&found, "crank").0 - 2.788).abs() < 5e-4, "{:?}", joint(&found, "crank"));
    assert_same("lock", &found, &fixed);
}

#[test]
fn a_gripper_whose_mimic_relation_leaves_one_position_keeps_its_energy_to_rounding() {
    let Some(folder) = shared("repro/events") else { return };
    let found = report(&folder.join("pr2_min.urdf"), &[], &[], Some(0.6), 1e-9);
    // An impact on the limit of the arm is among the steps; roundings of 100 J, and 1e-12 of the steps.
    assert!(found.energy.max_relative_error < 1e-11, "{:e}", found.energy.max_relative_error);
    for finger in ["l_gripper_l_finger_joint", "l_gripper_r_parallel_root_joint"] {
        assert_eq!(joint(&found, finger).1, 0.0, "{finger}");
    }
}

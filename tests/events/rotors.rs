//! Joints with rotors (`armature`) move as the same joints that carry along sliders, each of the mass of the rotor: a hinge that turns by q moves its
//! slider by q, so that both have the kinetic energy `½ A q̇²`. The sliders are bodies, tied by mimic relations, and share no code with rotors.

use crate::common::scratch;
use crate::scene_files::{joint, report};
use catena::report::Report;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Rotors of the three joints of an arm [kg m², kg m², kg].
const ROTORS: [f64; 3] = [0.35, 0.08, 1.2];

/// The rotors as the robot has them.
#[derive(Clone, Copy, PartialEq)]
enum As {
    /// Without any.
    Nothing,
    Rotors,
    Sliders,
}

/// A column that turns about a leaning axis, an arm on it, and a hand that slides along the arm; in the scene file with more tables.
fn arm(folder: &Path, rotors: As, more: &str) -> PathBuf {
    let mut urdf = String::from("<robot name='r'><link name='base'/>");
    let link = |name: &str, at: &str, mass: f64, ixx: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='{at}'/><mass value='{mass}'/><inertia ixx='{ixx}' iyy='{}' izz='{}' \
             ixy='0' ixz='0' iyz='0'/></inertial><collision><origin xyz='{at}'/><geometry><sphere radius='0.05'/></geometry>\
             </collision></link>",
            1.3 * ixx,
            0.7 * ixx
        )
    };
    urdf += &link("l0", "0.1 0.05 0.2", 2.0, 0.02);
    urdf += &link("l1", "0.3 0 -0.02", 1.0, 0.03);
    urdf += &link("l2", "0.05 0 0", 0.4, 0.001);
    let joints =
        [("revolute", "0.2 0.1 1", "0 0 0"), ("revolute", "0 1 0", "0.1 0 0.4"), ("prismatic", "1 0 0", "0.5 0 0")];
    for (index, ((kind, axis, at), rotor)) in joints.iter().zip(ROTORS).enumerate() {
        let parent = if index == 0 { "base".to_string() } else { format!("l{}", index - 1) };
        let armature = if rotors == As::Rotors { format!("<dynamics armature='{rotor}'/>") } else { String::new() };
        write!(
            urdf,
            "<joint name='j{index}' type='{kind}'><parent link='{parent}'/><child link='l{index}'/><origin xyz='{at}'/>\
             <axis xyz='{axis}'/><limit lower='-inf' upper='inf' effort='inf' velocity='inf'/>{armature}</joint>"
        )
        .expect("text");
        if rotors == As::Sliders {
            // Across the weight, so that gravity does not move it.
            write!(
                urdf,
                "<link name='s{index}'><inertial><mass value='{rotor}'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' \
                 iyz='0'/></inertial></link><joint name='slider{index}' type='prismatic'><parent link='base'/><child link='s{index}'/>\
                 <axis xyz='1 0 0'/><mimic joint='j{index}'/><limit lower='-inf' upper='inf' effort='inf' velocity='inf'/></joint>"
            )
            .expect("text");
        }
    }
    urdf += "</robot>";
    let name = match rotors {
        As::Nothing => "bare",
        As::Rotors => "rotors",
        As::Sliders => "sliders",
    };
    std::fs::write(folder.join(format!("{name}.urdf")), urdf).expect("a robot");
    let scene = format!("[[robot]]\nurdf = \"{name}.urdf\"\n{more}");
    let file = folder.join(format!("{name}.toml"));
    std::fs::write(&file, scene).expect("a scene");
    file
}

/// Ends of a run with rotors, with sliders and without both.
fn three(folder: &str, more: &str, duration: f64) -> [Report; 3] {
    let folder = scratch(folder);
    let positions = [("j0", 0.2), ("j1", -0.3), ("j2", 0.05)];
    let velocities = [("j0", 1.5), ("j1", -2.0), ("j2", 0.4)];
    [As::Rotors, As::Sliders, As::Nothing].map(|rotors| {
        let file = arm(&folder, rotors, more);
        report(&file, &positions, &velocities, Some(duration), 1e-9)
    })
}

/// Whether the joints of the arm end in the same place, within a bound (rad or m, and 10 times that per second); and not where they end without rotors.
fn assert_same(what: &str, [rotors, sliders, bare]: &[Report; 3], bound: f64) {
    let off = |other: &Report| {
        ["j0", "j1", "j2"].map(|name| {
            let ((q, v), (other_q, other_v)) = (joint(rotors, name), joint(other, name));
            (q - other_q).abs().max(0.1 * (v - other_v).abs())
        })
    };
    let largest = |off: [f64; 3]| off.into_iter().fold(0.0, f64::max);
    println!("{what}: {:.1e} from sliders, {:.1e} from none", largest(off(sliders)), largest(off(bare)));
    assert!(largest(off(sliders)) < bound, "{what}: {:?}", off(sliders));
    assert!(largest(off(bare)) > 0.01, "{what}: rotors do nothing");
}

fn impacts(report: &Report) -> usize {
    report.events.list.iter().filter(|event| event.kind.ends_with("_impact")).count()
}

#[test]
fn a_free_arm_and_one_with_springs_and_dampers_move_as_with_sliders() {
    // The tolerance of both runs.
    assert_same("free", &three("free", "", 2.0), 1e-9);
    let damped = "[[joint]]\nname = \"j1\"\ndamping = 0.4\n[[spring]]\njoint = \"j0\"\nstiffness = 20.0\n";
    assert_same("springs and dampers", &three("damped", damped, 2.0), 1e-9);
}

#[test]
fn impacts_on_limits_friction_and_motors_feel_rotors_as_sliders() {
    // Impacts magnify the tolerance of both runs a hundredfold.
    let limits = "[[joint]]\nname = \"j1\"\nlimit = [-0.6, 0.7]\nrestitution = 0.6\n[[joint]]\nname = \"j2\"\nlimit = [-0.1, 0.1]\n";
    let reports = three("limits", limits, 1.5);
    assert!(impacts(&reports[0]) > 3, "{:?}", reports[0].events);
    assert_same("limits", &reports, 1e-7);
    let friction = "[[joint]]\nname = \"j0\"\nfriction = 1.5\n[[joint]]\nname = \"j1\"\nfriction = 4.0\n\
                    [[motor]]\njoint = \"j1\"\nkind = \"position\"\ntarget = -0.5\nkp = 60.0\nkd = 3.0\nmax_effort = 9.0\n";
    assert_same("friction and a motor", &three("friction", friction, 1.5), 1e-8);
}

#[test]
fn contacts_and_loops_feel_rotors_as_sliders() {
    let floor = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\npose = { position = [0, 0, -0.05] }\n\
                 [contact]\nfriction = 0.4\nrestitution = 0.3\n";
    let reports = three("floor", floor, 1.2);
    assert!(impacts(&reports[0]) > 1, "{:?}", reports[0].events);
    assert_same("floor", &reports, 1e-7);
    // The hand is tied to a point by a rod, which leaves two freedoms of three.
    let rod = "[[loop]]\nname = \"rod\"\ntype = \"distance\"\na = { link = \"l2\", position = [0.1, 0, 0] }\n\
               b = { link = \"world\", position = [0.2, 0.9, 0.5] }\n";
    // The steps differ: mimic relations keep the tree of the file. The tolerance of both, magnified by a few seconds.
    assert_same("a loop", &three("loop", rod, 2.0), 1e-8);
}

/// A pendulum of 2 kg m² about its hinge, and a rotor of 3 kg m² behind a gear of 10 which turns with it; or of 302 kg m² and no rotor.
fn pendulum(folder: &Path, geared: bool) -> PathBuf {
    let (own, rotor) = if geared {
        (
            2.0,
            "<transmission name='t'><joint name='hinge'/><actuator name='m'><mechanicalReduction>10</mechanicalReduction>\
               <rotorInertia>3</rotorInertia></actuator></transmission>",
        )
    } else {
        (302.0, "")
    };
    // 1.5 kg at 0.8 m have 0.96 kg m² of it.
    let urdf = format!(
        "<robot name='p'><link name='base'/><link name='rod'><inertial><origin xyz='0 0 -0.8'/><mass value='1.5'/>\
         <inertia ixx='{0}' iyy='{0}' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='hinge' type='continuous'>\
         <parent link='base'/><child link='rod'/><axis xyz='0 1 0'/></joint>{rotor}</robot>",
        own - 0.96
    );
    let file = folder.join(format!("pendulum{}.urdf", u8::from(geared)));
    std::fs::write(&file, urdf).expect("a robot");
    file
}

#[test]
fn a_pendulum_with_a_geared_rotor_swings_with_the_inertia_of_both() {
    let folder = scratch("pendulum");
    let ends = [true, false].map(|geared| {
        let end = report(&pendulum(&folder, geared), &[("hinge", 2.0)], &[], Some(60.0), 1e-11);
        joint(&end, "hinge")
    });
    println!("{ends:?}");
    assert!((ends[0].0 - ends[1].0).abs() < 1e-10 && (ends[0].1 - ends[1].1).abs() < 1e-10, "{ends:?}");
}

#[test]
fn the_energy_of_a_run_has_the_energy_of_rotors() {
    let folder = scratch("energy");
    let file = arm(&folder, As::Rotors, "");
    let end = report(&file, &[("j0", 0.2), ("j1", -0.3)], &[("j0", 1.5), ("j1", -2.0)], Some(5.0), 1e-10);
    // The tolerance; without the rotors, which have a fifth of the energy at the start, it would be off by a tenth.
    assert!(end.energy.max_relative_error < 1e-9, "{:?}", end.energy);
}

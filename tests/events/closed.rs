//! Closed loops: a parallelogram with friction in all its hinges is a friction pendulum (J2b), and a slider needs no mass in a scissor lift.

use crate::exact::{answer, near};
use crate::mechanisms::*;
use crate::scene_files::{report, scene_of};
use catena::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::{Interpolation, Target};
use catena::mechanism::motion::event::EventKind;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// Two bars of J1's data at x = 0 and x = 2 that carry a coupler of 2 kg, 1 m below their hinges; all axes along y.
pub fn parallelogram(effort: f64) -> Mechanism {
    let bar = |name: &str, x: f64| hinge(name, None, Vector3::new(x, 0.0, 0.0), 0.5, 2.0, 0.02);
    // The coupler hangs on the first bar, 1 m below its hinge; its centre of mass is 1 m further along x.
    let mut coupler = hinge("coupler", Some(0), Vector3::new(0.0, 0.0, -0.5), 0.0, 2.0, 0.1);
    let turn = Rotation3::from_matrix_unchecked(Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0));
    coupler.joint.on_child = Pose::from_parts(Translation3::new(-1.0, 0.0, 0.0), turn);
    let mut mechanism = mechanism(vec![bar("first", 0.0), coupler, bar("second", 2.0)]);
    let end = |body: usize, at: Vector3<f64>| Attachment {
        body: Some(body),
        frame: Pose::from_parts(Translation3::from(at), turn),
    };
    mechanism.loops.push(LoopJoint {
        name: "closure".into(),
        kind: LoopKind::Revolute,
        a: end(1, Vector3::new(1.0, 0.0, 0.0)),
        b: end(2, Vector3::new(0.0, 0.0, -0.5)),
    });
    // Friction of the hinge that closes the loop is that of the coupler's other end: it turns as much.
    friction(&mut mechanism, 0, effort);
    friction(&mut mechanism, 1, 2.0 * effort);
    friction(&mut mechanism, 2, effort);
    mechanism
}

#[test]
fn a_parallelogram_with_friction_in_its_hinges_turns_like_a_friction_pendulum() {
    let Some(exact) = answer("J2") else { return };
    let mechanism = parallelogram(0.45);
    let done = run(&mechanism, &at_rest(&mechanism, &[1.3, -1.3, 1.3]), 13.0, fixed(9, 0.05));
    // √(3.04/(4 · 0.52))
    let slower = (3.04_f64 / (4.0 * 0.52)).sqrt();
    let turns: Vec<f64> = of_kind(&done, EventKind::Reversal).iter().map(|event| event.time).collect();
    for time in exact[..12].iter().map(|turn| turn[2]) {
        let nearest = turns.iter().map(|found| (found - slower * time).abs()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-10, "no turn at {}: {turns:?}", slower * time);
    }
    near(done.state.position[0], exact[12][1], 1e-10);
    assert!(done.state.velocity.iter().all(|&rate| rate == 0.0), "{:?}", done.state);
    assert!(of_kind(&done, EventKind::Stick).len() == 3, "{:?}", done.events);
    assert!(done.summary.max_relative_energy_error < 1e-11, "{:?}", done.summary);
}

#[test]
fn a_loop_with_friction_limits_and_a_motor_balances_its_energy_and_is_held_in_the_end() {
    let mut mechanism = parallelogram(0.45);
    limit(&mut mechanism, 0, -0.3, 1.35, 0.3);
    let target =
        Target::table(&[(0.0, 0.0), (1.0, 2.0), (2.0, -1.0), (3.0, 0.0)], Interpolation::Cubic).expect("a table");
    motor(&mut mechanism, 2, MotorLaw::Velocity { kd: 8.0 }, target, 12.0, 0.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[1.3, -1.3, 1.3]), 8.0, fixed(9, 0.02));
    for kind in [EventKind::LimitImpact, EventKind::Saturation, EventKind::Unsaturation, EventKind::Stick] {
        assert!(done.summary.events.of(kind) > 0, "no {}: {:?}", kind.name(), done.events);
    }
    assert!(done.summary.max_relative_energy_error < 1e-10, "{:?}", done.summary);
    assert!(done.summary.max_violation.position < 1e-12, "{:?}", done.summary);
    // The same by another number of stages and other steps.
    let again = run(&mechanism, &at_rest(&mechanism, &[1.3, -1.3, 1.3]), 8.0, fixed(7, 0.013));
    for (one, other) in done.state.position.iter().zip(&again.state.position) {
        near(*one, *other, 1e-9);
    }
    assert_eq!(done.summary.events, again.summary.events);
}

#[test]
fn a_scissor_lift_whose_slider_has_no_mass_moves_as_one_with_hardly_any() {
    // A scissor lift of two stages whose foot slides: platform and links fall as with a slider of a microgram.
    let lift = |slider: &str| {
        let rod = |name: &str, mass: f64, inertia: f64| {
            format!(
                "<link name='{name}'><inertial><origin xyz='0.5 0 0'/><mass value='{mass}'/>\
                 <inertia ixx='0.01' ixy='0' ixz='0' iyy='{inertia}' iyz='0' izz='{inertia}'/></inertial></link>"
            )
        };
        let hinge = |name: &str, parent: &str, child: &str, x: f64| {
            format!(
                "<joint name='{name}' type='continuous'><origin xyz='{x} 0 0'/><parent link='{parent}'/><child link='{child}'/><axis xyz='0 -1 0'/></joint>"
            )
        };
        let slide = |name: &str, parent: &str, child: &str| {
            format!(
                "<joint name='{name}' type='prismatic'><parent link='{parent}'/><child link='{child}'/><axis xyz='1 0 0'/>\
                 <limit lower='0.1' upper='1' effort='0' velocity='9'/></joint>"
            )
        };
        [
            "<link name='base'/>".to_owned(),
            rod("a1", 3.3, 0.29),
            rod("b1", 3.3, 0.29),
            rod("a2", 3.1, 0.28),
            rod("b2", 3.1, 0.28),
            format!("<link name='sl'>{slider}</link>"),
            "<link name='top'><inertial><origin xyz='0.4 0 0.05'/><mass value='7.7'/>\
             <inertia ixx='0.4' ixy='0' ixz='0' iyy='0.6' iyz='0' izz='0.9'/></inertial></link>"
                .to_owned(),
            "<link name='ts'><inertial><mass value='0.2'/><inertia ixx='0.001' ixy='0' ixz='0' iyy='0.001' iyz='0' izz='0.001'/></inertial></link>"
                .to_owned(),
            hinge("ja1", "base", "a1", 0.0),
            slide("jsl", "base", "sl"),
            hinge("jb1", "sl", "b1", 0.0),
            hinge("ja2", "b1", "a2", 1.0),
            hinge("jb2", "a1", "b2", 1.0),
            hinge("jt", "b2", "top", 1.0),
            slide("js", "top", "ts"),
        ]
        .concat()
    };
    let closing = |name: &str, a: [&str; 2], b: [&str; 2]| {
        let end = |[link, x]: [&str; 2]| format!("{{ link = \"{link}\", position = [{x}, 0, 0], axis = [0, 1, 0] }}");
        format!("[[loop]]\nname = \"{name}\"\ntype = \"revolute\"\na = {}\nb = {}\n", end(a), end(b))
    };
    let text = format!(
        "[[robot]]\nurdf = \"robot.urdf\"\npositions = {{ js = 0.852524522060, ja1 = 0.55, jsl = 0.852524522060, jb1 = 2.591592653590, \
         ja2 = -2.041592653590, jb2 = 2.041592653590, jt = -2.591592653590 }}\n{}{}{}[[joint]]\nname = \"jsl\"\nfriction = 2.1\n",
        closing("m1", ["a1", "0.5"], ["b1", "0.5"]),
        closing("m2", ["a2", "0.5"], ["b2", "0.5"]),
        closing("ro", ["a2", "1"], ["ts", "0"]),
    );
    let light = "<inertial><mass value='1e-9'/><inertia ixx='1e-12' ixy='0' ixz='0' iyy='1e-12' iyz='0' izz='1e-12'/></inertial>";
    let [bare, light] = [("lift_bare", ""), ("lift_light", light)].map(|(folder, slider)| {
        let end = report(&scene_of(folder, &lift(slider), &text), &[], &[], Some(0.3), 1e-8);
        end.links.into_iter().find(|(name, _)| name == "top").expect("a link").1.center_of_mass
    });
    println!("{bare:?} {light:?}");
    // A millionth of a gram of the slider beside 20 kg, and twice the tolerance.
    for (bare, light) in bare.iter().zip(&light) {
        assert!((bare - light).abs() <= 3e-8, "{bare} {light}");
    }
    assert!(bare[2] < 0.7, "it falls: {bare:?}");
}

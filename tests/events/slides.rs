//! Slides: the Coulomb oscillator (J3), the slider on its stop (J8), two mimic fingers (J9).

use crate::exact::{answer, near};
use crate::mechanisms::*;
use catena::mechanism::description::closure::{Attachment, Mimic};
use catena::mechanism::description::forces::{JointSpring, PointSpring};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::event::EventKind;
use nalgebra::Vector3;

#[test]
fn a_coulomb_oscillator_loses_the_same_length_with_every_swing() {
    let mut mechanism = mechanism(vec![slide("rail", Vector3::x(), 1.5)]);
    friction(&mut mechanism, 0, 2.4);
    let coordinate = coordinate(&mechanism, 0);
    mechanism.forces.joint_springs.push(JointSpring { coordinate, stiffness: 60.0, rest: 0.0 });
    let done = run(&mechanism, &at_rest(&mechanism, &[0.53]), 5.0, fixed(9, 0.1));
    let half = std::f64::consts::PI * (1.5_f64 / 60.0).sqrt();
    assert_eq!(done.events.len(), 7, "{:?}", done.events);
    for (number, event) in done.events.iter().enumerate() {
        near(event.time, (number + 1) as f64 * half, 1e-13);
    }
    near(done.state.position[0], 0.03, 1e-14);
    near(done.summary.exchange.friction, 8.4, 1e-13);
}

#[test]
fn a_slider_on_its_stop_bounces_by_the_ratio_that_friction_leaves() {
    let Some(exact) = answer("J8") else { return };
    let mut mechanism = mechanism(vec![slide("rail", Vector3::z(), 1.2)]);
    limit(&mut mechanism, 0, 0.0, f64::INFINITY, 0.8);
    friction(&mut mechanism, 0, 2.5);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.5]), 2.0, fixed(5, 0.1));
    for (event, line) in of_kind(&done, EventKind::LimitImpact).iter().zip(&exact[..5]) {
        near(event.time, line[1], 1e-13);
        near(event.impulse.expect("of an impact"), line[2], 1e-13);
    }
    let rest = done.events.last().expect("events");
    assert_eq!(rest.kind, EventKind::Rest);
    near(rest.time, exact[5][0], 1e-8);
    assert_eq!((done.state.position[0], done.state.velocity[0]), (0.0, 0.0));
    // 1.2 kg fell half a metre: all of it is heat now.
    let lost = done.summary.exchange.friction + done.summary.exchange.impacts;
    near(lost, 1.2 * GRAVITY * 0.5, 1e-12);
}

#[test]
fn two_mimic_fingers_close_on_their_limits_together() {
    let mut mechanism = mechanism(vec![slide("left", Vector3::y(), 0.15), slide("right", -Vector3::y(), 0.15)]);
    let [leader, follower] = [0, 1].map(|body| coordinate(&mechanism, body));
    mechanism.mimics.push(Mimic {
        name: "right".into(),
        follower,
        leader,
        multiplier: 1.0,
        offset: 0.0,
        more: Vec::new(),
        over_time: None,
    });
    limit(&mut mechanism, 0, 0.0, 0.03, 0.0);
    limit(&mut mechanism, 1, 0.0, 0.03, 0.0);
    motor(&mut mechanism, 0, MotorLaw::Effort, Target::constant(1.2), f64::INFINITY, 0.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.0, 0.0]), 1.0, fixed(5, 0.05));
    let impacts = of_kind(&done, EventKind::LimitImpact);
    assert!(!impacts.is_empty(), "{:?}", done.events);
    // ½ (1.2 / 0.3) t² = 0.03
    near(impacts[0].time, 0.015_f64.sqrt(), 1e-13);
    near(done.state.position[0], 0.03, 1e-15);
    near(done.state.position[1], 0.03, 1e-15);
    assert_eq!(done.state.velocity, [0.0, 0.0]);
    // The work of the motor on the way is what the impact takes.
    near(done.summary.exchange.work, 0.036, 1e-14);
    near(done.summary.exchange.impacts, 0.036, 1e-14);
}

#[test]
fn a_spring_between_points_and_friction_share_a_slide() {
    // J3 once more, with a spring between points in place of the one in the joint: it changes its sign in the origin, so the
    // slide is beside it.
    let mut mechanism = mechanism(vec![slide("rail", Vector3::x(), 1.5)]);
    friction(&mut mechanism, 0, 2.4);
    mechanism.forces.point_springs.push(PointSpring {
        name: "spring".into(),
        a: Attachment { body: None, frame: Pose::translation(0.0, 0.3, 0.0) },
        b: Attachment { body: Some(0), frame: Pose::identity() },
        stiffness: 60.0,
        damping: 0.0,
        rest_length: 0.0,
    });
    let done = run(&mechanism, &at_rest(&mechanism, &[0.53]), 5.0, fixed(9, 0.05));
    assert_eq!(done.events.len(), 7, "{:?}", done.events);
    near(done.state.position[0], 0.03, 1e-12);
}

#[test]
fn a_slip_that_passes_near_its_stop_is_followed_at_every_tolerance() {
    // A ball slides up a slope of 37° and to the side. Its slip passes its stop at some mm/s and turns there within a millisecond.
    let folder = crate::common::scratch("passes_its_stop");
    let file = folder.join("ball.toml");
    let scene = "[scene]\ngravity = [0, 6, -8]\n\
         [[body]]\nname = \"b\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 2\npose.position = [0, 0, 0.1]\n\
         velocity.linear = [0.005, -1, 0]\n\
         [[obstacle]]\nname = \"f\"\nshape = { type = \"half_space\" }\nfriction = 0.1\n";
    std::fs::write(&file, scene).expect("a scene");
    let place = |end: &catena::report::Report, name: &str| {
        end.links.iter().find(|(own, _)| own == name).expect("a link").1.position
    };
    let fine = place(&crate::scene_files::report(&file, &[], &[], Some(1.0), 1e-11), "b");
    for tolerance in [1e-3, 1e-5, 1e-7, 1e-9] {
        let end = crate::scene_files::report(&file, &[], &[], Some(1.0), tolerance);
        let accuracy = end.accuracy.as_ref().expect("an estimate");
        assert!(accuracy.reached && accuracy.begun == 1, "{tolerance:e}: {accuracy:?}");
        let off = place(&end, "b").into_iter().zip(fine).map(|(own, fine)| (own - fine).abs()).fold(0.0, f64::max);
        assert!(off <= tolerance, "{tolerance:e}: {off:e} m");
    }
    // Three balls, two of them joined, that fall on a slope: 6.5e-5 m off at 1e-6 m, and told 5.4e-9 m, before such slips were followed.
    let file = folder.join("joined.toml");
    std::fs::write(&file, JOINED).expect("a scene");
    let [fine, coarse] =
        [1e-8, 1e-6].map(|tolerance| crate::scene_files::report(&file, &[], &[], Some(1.0), tolerance));
    for name in ["b0", "b1", "b2"] {
        let pairs = place(&fine, name).into_iter().zip(place(&coarse, name));
        let off = pairs.map(|(own, other)| (own - other).abs()).fold(0.0, f64::max);
        // The chaos of their impacts amplifies 1e-8 m.
        assert!(off <= 3e-6, "{name}: {off:e} m");
    }
}

/// Three balls over a slope.
const JOINED: &str = r#"
[[obstacle]]
name = "floor"
shape = { type = "half_space" }
pose = { position = [0,0,0], rpy = [0, -0.393, 0] }
friction = 0.481
restitution = 0.000
[[body]]
name = "b0"
shape = { type = "sphere", radius = 0.0918 }
mass = 3.348
pose = { position = [-0.0365, 0.1102, 0.450], rpy = [-0.2720, -0.0172, -0.8417] }
velocity = { linear = [-0.0753, -0.5845, -0.1896], angular = [-1.8751, 1.6710, -1.0059] }
[[body]]
name = "b1"
shape = { type = "sphere", radius = 0.0583 }
mass = 0.278
pose = { position = [-0.0533, -0.1281, 0.850], rpy = [-0.2823, -0.1865, 0.9193] }
velocity = { linear = [0.4992, -0.3981, -0.9222], angular = [1.9340, -0.9347, -3.6973] }
[[body]]
name = "b2"
shape = { type = "sphere", radius = 0.0504 }
mass = 2.542
pose = { position = [0.2634, -0.2056, 1.250], rpy = [-0.5493, 0.7021, -0.0142] }
velocity = { linear = [0.4441, 0.9204, -0.1113], angular = [-0.9238, -1.6772, -0.9033] }
[[loop]]
type="spherical"
a = { link = "b0", position = [0.1,0,0.1], axis=[0,1,0] }
b = { link = "b1", position = [-0.1,0,-0.1], axis=[0,1,0] }
[contact]
friction = 0.209
restitution = 0.241
[simulation]
duration = 1.0
"#;

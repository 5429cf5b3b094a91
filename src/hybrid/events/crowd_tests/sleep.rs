//! Crowds with trees that sleep against crowds that never do.

use super::{boxes, put};
use crate::events::crowd::contacts::Scene;
use crate::events::crowd::step::{Crowd, Made};
use crate::instant::dynamics::response::Response;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::touching::Touching;
use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
use crate::mechanism::description::course::Course;
use crate::mechanism::description::forces::LinkLoad;
use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;

/// Runs in steps of a length (s) to an end (s) under loads that may change, with trees that sleep or without.
fn run_with(
    mechanism: &Mechanism,
    state: &mut State,
    (step, end): (f64, f64),
    sleeps: bool,
    mut see: impl FnMut(&Made, &State),
) {
    let (elements, touching) = (Elements::new(mechanism), Touching::new(mechanism));
    let mut response = Response::new(mechanism);
    let mut crowd = Crowd::new(mechanism).expect("a tree");
    if !sleeps {
        crowd.keep_awake();
    }
    let scene = Scene { whole: mechanism, elements: &elements, touching: &touching };
    for _ in 0..(end / step).round() as usize {
        let mut forces = |at: &State, accelerations: &mut [f64], efforts: &mut [f64]| {
            response.accelerations(at, efforts, accelerations);
        };
        let made = crowd.step(scene, &mut forces, state, step, false).expect("a step");
        see(&made, state);
    }
}

#[test]
fn a_stack_sleeps_until_a_box_strikes_it_and_another_one_sleeps_on() {
    // Boxes of 0.2 m: three on each other, two on each other 2 m beside them, and one that falls by 0.6 m onto the three, off their middle.
    let mechanism = boxes(6, Vector3::repeat(0.1), 0.5, 0.0);
    let mut start = State::zero(&mechanism);
    (0..3).for_each(|body| put(&mut start, body, [0.01 * body as f64, 0.0, 0.1 + 0.2 * body as f64], [0.0; 3]));
    (3..5).for_each(|body| put(&mut start, body, [2.0, 0.0, 0.1 + 0.2 * (body - 3) as f64], [0.0; 3]));
    put(&mut start, 5, [0.08, 0.03, 1.3], [0.02, 0.01, 0.3]);
    let mut slept = [0.0; 2];
    let [asleep, awake] = [true, false].map(|sleeps| {
        let (mut state, mut struck) = (start.clone(), Vec::new());
        let (mut beside, mut before) = (Vec::new(), f64::INFINITY);
        run_with(&mechanism, &mut state, (1e-3, 0.6), sleeps, |made, state| {
            if (state.time - 0.35).abs() < 1e-9 {
                struck.clone_from(&state.position);
            }
            let energy = crate::events::effects::resting::energy(&mechanism, state).total();
            // As of piles.
            assert!(energy <= before + 3e-9, "{energy} after {before} at {}", state.time);
            before = energy;
            if made.slept > 0.3 {
                slept[usize::from(state.time > 0.34)] = made.slept;
                beside.push(state.position[21..35].to_vec());
            }
        });
        assert!(beside.windows(2).all(|two| two[0] == two[1]), "sleeping bodies do not move in any digit");
        assert_eq!(beside.is_empty(), !sleeps);
        struck
    });
    // Five of six boxes sleep in the flight, which ends at √(2 · 0.597/9.81) = 0.349 s, and two to the end.
    assert_eq!(slept, [5.0 / 6.0, 2.0 / 6.0]);
    // Gaps close to 3e-10 m, which turns a box by some times as much at its other corners. Corners that meet later amplify that in each run.
    for (one, other) in asleep.iter().zip(&awake) {
        assert!((one - other).abs() < 1e-8, "{one} {other}");
    }
}

#[test]
fn a_struck_stack_that_slept_or_started_a_picometre_beside_ends_where_one_that_never_slept_does() {
    // Three boxes of 0.2 m on each other, and one that falls by 0.6 m onto them, turned and off their middle: at 0.349 s.
    let mechanism = boxes(4, Vector3::repeat(0.1), 0.5, 0.0);
    let mut start = State::zero(&mechanism);
    (0..3).for_each(|body| put(&mut start, body, [0.01 * body as f64, 0.0, 0.1 + 0.2 * body as f64], [0.0; 3]));
    put(&mut start, 3, [0.08, 0.03, 1.3], [0.02, 0.01, 0.3]);
    let places = |sleeps: bool, moved: f64| {
        let (mut state, mut all) = (start.clone(), Vec::new());
        state.position[21] += moved;
        run_with(&mechanism, &mut state, (1e-3, 0.5), sleeps, |_, state| all.push(state.position.clone()));
        all
    };
    let awake = places(false, 0.0);
    let apart = |other: &[Vec<f64>]| -> Vec<f64> {
        let difference = |(one, other): (&f64, &f64)| (one - other).abs();
        let largest = |(one, other): (&Vec<f64>, &Vec<f64>)| one.iter().zip(other).map(difference).fold(0.0, f64::max);
        awake.iter().zip(other).map(largest).collect()
    };
    let [slept, moved, back] =
        [(true, 0.0), (false, 1e-12), (false, -1e-12)].map(|(sleeps, by)| apart(&places(sleeps, by)));
    println!("{:.1e} {:.1e} {:.1e} {:.1e}", slept[345], slept[349], slept[355], slept[499]);
    println!("{:.1e} {:.1e} {:.1e} {:.1e}", moved[345], moved[349], moved[355], moved[499]);
    // Sleep leaves gaps of 3e-10 m at the blow, and each step forces to 5e-9 of the largest: ten times what became of both. Where steps of the blow stay at
    // residuals of 1e-6, roundings decide which corner closes first, and the ends are 3e-3 m apart.
    let all = slept.iter().chain(&moved).chain(&back);
    assert!(all.clone().all(|apart| *apart < 2e-5), "{:e}", all.fold(0.0, |most: f64, apart| most.max(*apart)));
}

#[test]
fn a_box_that_sleeps_wakes_in_the_step_in_which_a_load_begins() {
    // 8 N on a box of 1 kg with μ = 0.5 from 0.3 s on: it slides from there with (8 − 4.905) m/s².
    let mut mechanism = boxes(2, Vector3::repeat(0.1), 0.5, 0.0);
    let course = Course::constant(1.0).between(0.3, f64::INFINITY);
    let force = Vector3::new(8.0, 0.0, 0.0);
    mechanism.forces.link_loads = vec![LinkLoad {
        body: 0,
        point: Vector3::new(0.0, 0.0, -0.1),
        force,
        torque: Vector3::zeros(),
        turns: false,
        course,
    }];
    let mut state = State::zero(&mechanism);
    put(&mut state, 0, [0.0, 0.0, 0.1], [0.0; 3]);
    put(&mut state, 1, [3.0, 0.0, 0.1], [0.0; 3]);
    let mut slept = [0.0; 2];
    run_with(&mechanism, &mut state, (1e-3, 0.5), true, |made, state| {
        slept[usize::from(state.time > 0.3005)] = made.slept;
    });
    assert_eq!(slept, [1.0, 0.5]);
    let speed = 0.2 * (8.0 - 0.5 * 9.81);
    // The load begins at the end of a step, or within one: a step of 3.1 mm/s.
    assert!((state.velocity[0] - speed).abs() < 3.2e-3, "{} {speed}", state.velocity[0]);
}

#[test]
fn a_bolt_falls_when_the_box_that_bore_it_has_slid_away_however_long_it_has_stood_still() {
    // A bolt on an upright slide stands on a box, which slides on without friction at 0.5 m/s. Its end passes the bolt at (0.1 + 0.03)/0.5 = 0.26 s.
    let mut mechanism = boxes(1, Vector3::repeat(0.1), 0.0, 0.0);
    let joint = Joint::new("slide", JointKind::Prismatic, Pose::translation(0.0, 0.0, 0.23), Pose::identity());
    let bolt = Body { name: "bolt".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(1e-3), joint };
    let nonsmooth = std::mem::take(&mut mechanism.nonsmooth);
    let bodies = vec![mechanism.bodies[0].clone(), bolt];
    mechanism = Mechanism::new("bolt", mechanism.gravity, bodies).expect("a box and a bolt");
    mechanism.nonsmooth = nonsmooth;
    let nonsmooth = &mut mechanism.nonsmooth;
    let shape = Shape::Box { half: Vector3::repeat(0.03) };
    nonsmooth.colliders.push(Collider::still("bolt", Some(1), Pose::identity(), shape));
    nonsmooth.pairs.push(ContactPair::without_moments(1, [1, 2], 0.0, 0.0));
    let mut start = State::zero(&mechanism);
    put(&mut start, 0, [0.0, 0.0, 0.1], [0.0; 3]);
    start.velocity[0] = 0.5;
    for sleeps in [true, false] {
        let mut state = start.clone();
        run_with(&mechanism, &mut state, (1e-3, 0.4), sleeps, |_, _| ());
        let fallen = 0.5 * 9.81 * 0.14_f64.powi(2);
        // It leaves within one step: g 0.14 h.
        assert!((state.position[7] + fallen).abs() < 1.5e-3, "sleeps: {sleeps}, {} m", state.position[7]);
    }
}

//! The pendulum on a limit and with friction (J1, J1b, J2), and the double pendulum with a knee (D1 to D3), with nine stages.

use crate::exact::{answer, near};
use crate::mechanisms::*;
use catena::mechanism::motion::event::{EventKind, FrictionState, Side};

/// Nine stages with steps of a tenth of a second leave roundings of the motion, amplified by the impacts: some 1e-14.
const ROUNDING: f64 = 5e-13;

#[test]
fn impacts_of_a_pendulum_on_its_limit_are_exact_in_time_impulse_and_state() {
    let Some(exact) = answer("J1") else { return };
    let mut mechanism = pendulum();
    limit(&mut mechanism, 0, -0.3, f64::INFINITY, 0.7);
    let done = run(&mechanism, &at_rest(&mechanism, &[1.0]), 6.0, fixed(9, 0.1));
    let impacts = of_kind(&done, EventKind::LimitImpact);
    assert_eq!(impacts.len(), 6, "{:?}", done.events);
    // Lines "impact k t … impulse …".
    for (event, line) in impacts.iter().zip(&exact[..5]) {
        near(event.time, line[1], ROUNDING);
        near(event.impulse.expect("of an impact"), line[2], ROUNDING);
    }
    // "state at 6.0 q … rate …"
    near(done.state.position[0], exact[6][1], ROUNDING);
    near(done.state.velocity[0], exact[6][2], ROUNDING);
    assert!(done.summary.max_relative_energy_error < 1e-13, "{:?}", done.summary);
}

#[test]
fn a_limit_on_the_near_side_brings_a_pendulum_to_rest_after_infinitely_many_impacts() {
    let Some(exact) = answer("J1b") else { return };
    let mut mechanism = pendulum();
    limit(&mut mechanism, 0, 0.3, f64::INFINITY, 0.6);
    let done = run(&mechanism, &at_rest(&mechanism, &[1.2]), 4.0, fixed(9, 0.1));
    for (event, time) in done.events.iter().zip(&exact[..5]) {
        near(event.time, time[1], ROUNDING);
    }
    let last = done.events.last().expect("events");
    assert_eq!(last.kind, EventKind::Rest);
    // What is left when the impacts are closed lasts 1e-6 s; its prediction is good to the rounding of so short flights.
    near(last.time, exact[6][0], 1e-8);
    assert_eq!((done.state.position[0], done.state.velocity[0]), (0.3, 0.0));
    assert_eq!(done.joints[0].limit, Some(Side::Lower));
}

#[test]
fn a_pendulum_with_friction_turns_where_it_should_and_sticks_in_its_dead_zone() {
    let Some(exact) = answer("J2") else { return };
    let mut mechanism = pendulum();
    friction(&mut mechanism, 0, 0.45);
    let done = run(&mechanism, &at_rest(&mechanism, &[1.3]), 12.0, fixed(9, 0.1));
    assert_eq!(done.events.len(), 13, "{:?}", done.events);
    for (event, turn) in done.events.iter().zip(&exact) {
        near(event.time, turn[2], ROUNDING);
    }
    assert!(done.events[..12].iter().all(|event| event.kind == EventKind::Reversal));
    assert_eq!(done.events[12].kind, EventKind::Stick);
    near(done.state.position[0], exact[12][1], ROUNDING);
    assert_eq!(done.state.velocity[0], 0.0);
    // "stuck at … since … heat …"
    near(done.summary.exchange.friction, exact[13][2], ROUNDING);
    assert_eq!(done.joints[0].friction, Some(FrictionState::Stuck));
    assert!(done.summary.max_relative_energy_error < 1e-13, "{:?}", done.summary);
}

#[test]
fn the_turning_angles_of_a_friction_pendulum_are_those_of_the_energy_equation() {
    let Some(exact) = answer("J2") else { return };
    let mut mechanism = pendulum();
    friction(&mut mechanism, 0, 0.45);
    for turn in &exact[..13] {
        let done = run(&mechanism, &at_rest(&mechanism, &[1.3]), turn[2], fixed(9, 0.1));
        near(done.state.position[0], turn[1], ROUNDING);
    }
}

/// Hip and knee of the double pendulum at the end of a run, as the answers give them: a1, knee, w1, knee rate.
fn hip_and_knee(state: &catena::mechanism::motion::state::State) -> [f64; 4] {
    [state.position[0], state.position[1], state.velocity[0], state.velocity[1]]
}

#[test]
fn a_knee_bounces_on_its_limit_at_the_right_instants() {
    let Some(exact) = answer("D1") else { return };
    let mechanism = double_pendulum(0.8);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.8, 0.5]), 1.2, fixed(9, 0.05));
    assert_eq!(done.events.len(), 4, "{:?}", done.events);
    for (event, line) in done.events.iter().zip(&exact) {
        near(event.time, line[0], ROUNDING);
        near(event.impulse.expect("of an impact"), line[2], ROUNDING);
    }
    for (found, &wanted) in hip_and_knee(&done.state).into_iter().zip(&exact[4][1..]) {
        near(found, wanted, ROUNDING);
    }
    assert!(done.summary.max_relative_energy_error < 1e-12, "{:?}", done.summary);
}

#[test]
fn a_knee_without_restitution_leaves_its_limit_at_once_or_rests_until_it_is_pulled_away() {
    let Some(exact) = answer("D2") else { return };
    let mechanism = double_pendulum(0.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.8, 0.5]), 2.5, fixed(9, 0.05));
    let kinds: Vec<EventKind> = done.events.iter().map(|event| event.kind).collect();
    use EventKind::{LimitImpact, Release, Rest};
    assert_eq!(kinds, [LimitImpact, LimitImpact, Rest, Release, LimitImpact]);
    for (event, line) in [(0, 0), (1, 2), (3, 4), (4, 5)] {
        near(done.events[event].time, exact[line][0], ROUNDING);
    }
    for (found, &wanted) in hip_and_knee(&done.state).into_iter().zip(&exact[7][1..]) {
        near(found, wanted, ROUNDING);
    }
    assert!(done.summary.max_relative_energy_error < 1e-12, "{:?}", done.summary);
}

#[test]
fn impacts_of_a_knee_accumulate_and_it_rests_until_it_is_pulled_away() {
    let Some(exact) = answer("D3") else { return };
    let mechanism = double_pendulum(0.5);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.8, 0.5]), 1.5, fixed(9, 0.05));
    for (event, line) in done.events.iter().zip(&exact[..8]) {
        near(event.time, line[0], ROUNDING);
    }
    // The end of the accumulation is a prediction from flights of 1e-6 s.
    near(of_kind(&done, EventKind::Rest)[0].time, exact[8][0], 1e-9);
    near(of_kind(&done, EventKind::Release)[0].time, exact[10][0], ROUNDING);
    for (found, &wanted) in hip_and_knee(&done.state).into_iter().zip(&exact[11][1..]) {
        near(found, wanted, ROUNDING);
    }
    assert!(done.summary.max_relative_energy_error < 1e-12, "{:?}", done.summary);
}

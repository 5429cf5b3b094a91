//! Motors: bounds (J5, J6), samples (J7), a table with friction (J4), gains in the equations of the step.

use crate::exact::{answer, near};
use crate::mechanisms::*;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::{Interpolation, Target};
use catena::mechanism::motion::event::EventKind;

/// A wheel with a position motor.
fn wheel_at(kd: f64, max_effort: f64, period: f64) -> catena::mechanism::description::mechanism::Mechanism {
    let mut mechanism = wheel(0.4);
    let law = MotorLaw::Position { kp: 50.0, kd };
    motor(&mut mechanism, 0, law, Target::constant(0.9), max_effort, period);
    mechanism
}

#[test]
fn a_motor_reaches_its_bound_and_comes_back_at_the_exact_instants() {
    let Some(exact) = answer("J5") else { return };
    // Five kinks and the end with kd = 3, then six and the end with kd = 0.5.
    for (kd, lines) in [(3.0, &exact[..6]), (0.5, &exact[7..14])] {
        let mechanism = wheel_at(kd, 6.0, 0.0);
        let (end, kinks) = lines.split_last().expect("lines");
        // Two kinks are 0.05 s apart: some steps have two. With the longest steps nine stages leave 1e-11.
        for (step, allowed) in [(0.25, 1e-10), (0.1, 1e-12), (0.03, 1e-12)] {
            let done = run(&mechanism, &at_rest(&mechanism, &[0.0]), 2.0, fixed(9, step));
            assert_eq!(done.events.len(), kinks.len(), "{step}: {:?}", done.events);
            for (event, line) in done.events.iter().zip(kinks) {
                near(event.time, line[line.len() - 3], allowed);
            }
            near(done.state.position[0], end[1], allowed);
            near(done.state.velocity[0], end[2], 10.0 * allowed);
            let kinds = [EventKind::Saturation, EventKind::Unsaturation];
            assert!(done.events.iter().all(|event| kinds.contains(&event.kind)));
            assert!(done.summary.max_relative_energy_error < 10.0 * allowed, "{:?}", done.summary);
        }
    }
}

#[test]
fn a_velocity_motor_leaves_its_bound_when_the_wheel_is_fast_enough() {
    let mut mechanism = wheel(0.4);
    motor(&mut mechanism, 0, MotorLaw::Velocity { kd: 1.6 }, Target::constant(8.0), 2.5, 0.0);
    let Some(exact) = answer("J6") else { return };
    let done = run(&mechanism, &at_rest(&mechanism, &[0.0]), 3.0, fixed(9, 0.1));
    assert_eq!(done.events.len(), 1);
    near(done.events[0].time, 1.03, 1e-13);
    near(done.state.position[0], exact[1][1], 1e-12);
    near(done.state.velocity[0], exact[1][2], 1e-13);
    // Its work is the kinetic energy.
    near(done.summary.exchange.work, 0.2 * exact[1][2].powi(2), 1e-11);
}

#[test]
fn a_sampled_motor_holds_its_effort_between_ticks() {
    let mechanism = wheel_at(3.0, f64::INFINITY, 0.02);
    let Some(exact) = answer("J7") else { return };
    for step in [0.1, 0.013] {
        for line in &exact {
            let &[time, position, rate] = &line[..] else { continue };
            let done = run(&mechanism, &at_rest(&mechanism, &[0.0]), time, fixed(9, step));
            near(done.state.position[0], position, 1e-12);
            near(done.state.velocity[0], rate, 1e-11);
        }
    }
}

#[test]
fn a_sampled_motor_reports_the_ticks_at_which_it_reaches_its_bound_and_comes_back() {
    let (inertia, period, bound) = (0.4, 0.02, 6.0);
    let mechanism = wheel_at(3.0, bound, period);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.0]), 2.0, fixed(9, 0.013));
    // The exact recursion: a constant effort between ticks.
    let (mut position, mut rate, mut expected) = (0.0, 0.0, Vec::new());
    let mut before: Option<f64> = None;
    for tick in 0..100 {
        let unbounded: f64 = 50.0 * (0.9 - position) - 3.0 * rate;
        let effort = unbounded.clamp(-bound, bound);
        let at_bound = |effort: f64| effort.abs() == bound;
        if let Some(before) = before {
            let time = f64::from(tick) * period;
            if at_bound(before) && effort != before {
                expected.push((time, EventKind::Unsaturation));
            }
            if at_bound(effort) && effort != before {
                expected.push((time, EventKind::Saturation));
            }
        }
        before = Some(effort);
        let acceleration = effort / inertia;
        position += rate * period + 0.5 * acceleration * period * period;
        rate += acceleration * period;
    }
    assert!(expected.len() > 3, "{expected:?}");
    assert_eq!(done.events.len(), expected.len(), "{:?} for {expected:?}", done.events);
    for (event, (time, kind)) in done.events.iter().zip(expected) {
        assert_eq!(event.kind, kind);
        near(event.time, time, 1e-12);
    }
}

#[test]
fn friction_sticks_and_slips_under_an_effort_from_a_table() {
    let mut mechanism = wheel(0.25);
    friction(&mut mechanism, 0, 1.5);
    let points = [(0.0, 0.0), (0.5, 2.0), (1.5, -2.0), (2.5, 2.0), (3.5, -2.0), (4.5, 2.0)];
    let target = Target::table(&points, Interpolation::Linear).expect("a table");
    motor(&mut mechanism, 0, MotorLaw::Effort, target, f64::INFINITY, 0.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.0]), 3.7, fixed(9, 0.1));
    let Some(exact) = answer("J4") else { return };
    let kinds = [EventKind::Slip, EventKind::Stick];
    let wanted: Vec<(EventKind, f64)> = (0..7).map(|line| (kinds[line % 2], exact[line][0])).collect();
    assert_eq!(done.events.len(), wanted.len(), "{:?}", done.events);
    for (event, (kind, time)) in done.events.iter().zip(wanted) {
        assert_eq!(event.kind, kind, "{:?}", done.events);
        near(event.time, time, 1e-12);
    }
    near(done.state.position[0], exact[7][1], 1e-13);
    near(done.state.velocity[0], exact[7][2], 1e-12);
    near(done.summary.exchange.friction, exact[7][3], 1e-12);
    assert!(done.summary.max_relative_energy_error < 1e-11, "{:?}", done.summary);
}

#[test]
fn a_stiff_motor_costs_iterations_and_not_steps() {
    // kd h/J = 1250 and h √(kp/J) = 158: far beyond any explicit step.
    let mut mechanism = wheel(0.4);
    motor(&mut mechanism, 0, MotorLaw::Position { kp: 1e6, kd: 5e3 }, Target::constant(0.9), f64::INFINITY, 0.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.9]), 1.0, fixed(9, 0.1));
    assert_eq!((done.summary.steps, done.summary.cost.rejected.total()), (10, 0));
    near(done.state.position[0], 0.9, 1e-12);
}

#[test]
fn a_motor_follows_a_moving_target_with_the_error_of_its_law() {
    // Under a ramp of one radian a second a position motor that knows the rate has no error at all once it is there.
    let mut mechanism = wheel(0.4);
    let target = Target::table(&[(0.0, 0.0), (5.0, 5.0)], Interpolation::Linear).expect("a table");
    motor(&mut mechanism, 0, MotorLaw::Position { kp: 50.0, kd: 12.0 }, target, f64::INFINITY, 0.0);
    let mut start = at_rest(&mechanism, &[0.0]);
    start.velocity[0] = 1.0;
    let done = run(&mechanism, &start, 4.0, fixed(5, 0.1));
    near(done.state.position[0], 4.0, 1e-12);
    near(done.state.velocity[0], 1.0, 1e-12);
}

#[test]
fn a_velocity_motor_without_bound_is_an_exponential() {
    let mut mechanism = wheel(0.4);
    motor(&mut mechanism, 0, MotorLaw::Velocity { kd: 1.6 }, Target::constant(8.0), f64::INFINITY, 0.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.0]), 2.0, fixed(9, 0.1));
    let left = (-4.0 * 2.0_f64).exp();
    near(done.state.velocity[0], 8.0 * (1.0 - left), 1e-13);
    near(done.state.position[0], 8.0 * 2.0 - 2.0 * (1.0 - left), 1e-13);
}

//! The order 2s − 2 of the scheme is kept through events of contacts, in their times and in the states after them.

use crate::contacts::{ball, block, placed};
use crate::contacts_rocking::rocking;
use crate::contacts_rod::{leaning, rod, seen};
use crate::exact::{answer, near};
use crate::mechanisms::{GRAVITY, fixed, of_kind, run};
use catena::mechanism::motion::event::EventKind;
use catena::simulation::Finished;
use nalgebra::Vector3;

/// The mean slope of errors over steps, each half of the one before.
fn slope(errors: &[f64]) -> f64 {
    (errors[0] / errors[errors.len() - 1]).log2() / (errors.len() - 1) as f64
}

/// Checks the slopes of some errors of a run over the steps.
fn keeps_order<const N: usize>(
    name: &str,
    stages: usize,
    longest: f64,
    floor: f64,
    errors: impl Fn(usize, f64) -> [f64; N],
) {
    let found: Vec<[f64; N]> = (0..4).map(|halved| errors(stages, longest * 0.5_f64.powi(halved))).collect();
    for index in 0..N {
        let own: Vec<f64> = found.iter().map(|errors| errors[index]).collect();
        println!("{name}, {stages} stages, error {index}: {own:?}, slope {}", slope(&own));
        // A fixed grid has steps of any length before and after an event: the mean of the slopes scatters by up to half.
        let order = (2 * stages - 2) as f64;
        assert!(slope(&own) > order - 0.6 || own[3] < floor, "{name}, {stages} stages, error {index}: {own:?}");
    }
}

/// Checks that nine stages err by no more than a bound with each of some steps.
fn is_right_with_nine_stages<const N: usize>(
    name: &str,
    steps: [f64; 2],
    bound: f64,
    errors: impl Fn(usize, f64) -> [f64; N],
) {
    for step in steps {
        let errors = errors(9, step);
        println!("{name}, 9 stages: {errors:?}");
        assert!(errors.iter().all(|&error| error <= bound), "{name}, {step} s: {errors:?}");
    }
}

/// The times of the events of a run that are not at its start.
fn times(finished: &Finished) -> Vec<f64> {
    finished.events.iter().map(|event| event.time).filter(|&time| time > 0.0).collect()
}

#[test]
fn order_is_kept_when_a_rod_sticks_slips_and_turns_its_slip_round() {
    let Some(lines) = answer("C6") else { return };
    let errors = |stages: usize, step: f64| {
        let whole = rod(0.35, true);
        let found = times(&run(&whole, &leaning(&whole, 0.3, 0.0), lines[8][0] + 0.01, fixed(stages, step)));
        let one = rod(0.35, false);
        let state = seen(&run(&one, &leaning(&one, 0.3, 0.0), lines[8][0], fixed(stages, step)).state);
        let event = |number: usize| (found[number] - lines[6 + number][0]).abs();
        let end = (state[1] - lines[8][1]).hypot(state[3] - lines[8][2]);
        [event(0), event(1), event(2), end]
    };
    keeps_order("C6", 3, 0.04, 1e-12, errors);
    keeps_order("C6", 5, 0.16, 1e-12, errors);
    is_right_with_nine_stages("C6", [0.1, 0.05], 1e-10, errors);
}

#[test]
fn order_is_kept_on_a_curved_slide_to_its_stop() {
    let Some(lines) = answer("C3") else { return };
    let errors = |stages: usize, step: f64| {
        let block = block(0.5);
        let start = placed(&block, Vector3::new(0.0, 0.0, 0.05), Vector3::new(0.0, 1.5, 0.0), Vector3::zeros());
        let finished = run(&block, &start, 1.2, fixed(stages, step));
        let place = &finished.state.position;
        let stop = times(&finished)[0] - lines[0][0];
        [stop.abs(), (place[0] - lines[0][1]).hypot(place[1] - lines[0][2])]
    };
    keeps_order("C3", 3, 0.1, 1e-11, errors);
    keeps_order("C3", 5, 0.2, 1e-11, errors);
    is_right_with_nine_stages("C3", [0.1, 0.05], 1e-10, errors);
}

#[test]
fn order_is_kept_when_a_block_rocks_from_edge_to_edge() {
    let Some(lines) = answer("C8") else { return };
    let (block, start) = rocking();
    let errors = |stages: usize, step: f64| {
        let finished = run(&block, &start, 1.0, fixed(stages, step));
        let impacts = of_kind(&finished, EventKind::ContactImpact);
        assert_eq!(impacts.len(), 3, "{stages} stages, {step} s: {:?}", finished.events);
        [0, 1, 2].map(|number| (impacts[number].time - lines[1 + number][1]).abs())
    };
    keeps_order("C8", 3, 0.08, 1e-12, errors);
    keeps_order("C8", 5, 0.16, 1e-12, errors);
    is_right_with_nine_stages("C8", [0.1, 0.05], 1e-12, errors);
}

#[test]
fn order_is_kept_after_an_impulse_that_stops_a_rod() {
    let Some(lines) = answer("C7") else { return };
    let rod = rod(2.0, true);
    let start = leaning(&rod, 0.6, -1.0);
    let errors = |stages: usize, step: f64| {
        let slips = times(&run(&rod, &start, 0.6, fixed(stages, step)))[0];
        let [turned, rate, x, _] = seen(&run(&rod, &start, 0.2, fixed(stages, step)).state);
        let there = &lines[4];
        let state = (x - there[0]).hypot(turned - there[1]).hypot(rate - there[2]);
        [(slips - lines[3][0]).abs(), state]
    };
    keeps_order("C7", 3, 0.08, 1e-12, errors);
    keeps_order("C7", 5, 0.16, 1e-12, errors);
    is_right_with_nine_stages("C7", [0.1, 0.05], 1e-10, errors);
}

#[test]
fn motions_that_are_polynomials_between_events_are_exact_whatever_the_stages() {
    let (Some(c1), Some(c2), Some(c4)) = (answer("C1"), answer("C2"), answer("C4")) else { return };
    let down = Vector3::new(0.0, 0.0, -GRAVITY);
    let zero = Vector3::zeros();
    for stages in [3, 5, 9] {
        let steps = || fixed(stages, 0.05);
        let bouncing = ball(0.05, down, 0.3, 0.7);
        let finished = run(&bouncing, &placed(&bouncing, Vector3::z() * 0.65, zero, zero), 3.0, steps());
        for (line, impact) in c1[..6].iter().zip(of_kind(&finished, EventKind::ContactImpact)) {
            near(impact.time, line[1], 1e-12);
        }
        near(of_kind(&finished, EventKind::Rest)[0].time, c1[6][0], 1e-12);
        for (friction, line) in [(0.45, &c2[0]), (0.25, &c2[1])] {
            let block = block(friction);
            let start = placed(&block, Vector3::z() * 0.05, Vector3::x() * -2.0, zero);
            let finished = run(&block, &start, line[1] + 0.1, steps());
            // A slip stops to 1e-10 of the fastest, at 8 m/s².
            near(times(&finished)[0], line[1], 3e-11);
            if friction == 0.45 {
                near(-finished.state.position[0], line[2], 1e-12);
            }
        }
        let ball = ball(0.12, down, 0.3, 0.0);
        let at = Vector3::z() * 0.12;
        let back = placed(&ball, at, Vector3::new(1.8, 0.0, 0.0), Vector3::new(0.0, -15.0, 0.0));
        let finished = run(&ball, &back, 3.0, steps());
        near(of_kind(&finished, EventKind::Stick)[0].time, c4[0][0], 1e-12);
        near(finished.state.position[0], c4[0][4], 1e-11);
    }
}

#[test]
fn a_ball_with_spin_about_three_axes_comes_to_roll_where_it_should_whatever_the_stages() {
    let Some(lines) = answer("C5") else { return };
    let ball = ball(0.12, Vector3::new(0.0, 0.0, -GRAVITY), 0.3, 0.0);
    let spin = Vector3::new(12.0, -10.0, 25.0);
    let start = placed(&ball, Vector3::z() * 0.12, Vector3::new(2.0, 0.0, 0.0), spin);
    // Its slip keeps its direction and force and torque are constant: with the angular velocity that these add up to slips are exact, however far the ball
    // turns in a step. With the rate of its rotation matrix the stop was 7e-5 s late with three stages of 1.25 ms.
    for stages in [2, 3, 4, 5, 9] {
        // The shortest with those that were late.
        let steps: &[f64] = if stages == 3 { &[0.05, 0.02, 0.00125] } else { &[0.05, 0.02] };
        for &step in steps {
            let finished = run(&ball, &start, 1.0, fixed(stages, step));
            let kinds: Vec<EventKind> = finished.events.iter().map(|event| event.kind).collect();
            assert_eq!(kinds, [EventKind::Stick], "{stages} stages, {step} s");
            // A slip stops to 1e-10 of the fastest, at 10 m/s².
            near(times(&finished)[0], lines[0][2], 3e-11);
            // It rolls on with the velocity it has then.
            let since = 2.0 - finished.state.time;
            for axis in 0..2 {
                near(finished.state.position[axis] + since * finished.state.velocity[axis], lines[1][axis], 1e-9);
            }
        }
    }
}

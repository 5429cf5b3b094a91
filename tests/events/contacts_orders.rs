//! The order 2s − 2 of the scheme is kept through events of contacts, in their times and in the states after them.

use crate::contacts::{block, placed};
use crate::contacts_rod::{leaning, rod, seen};
use crate::exact::answer;
use crate::mechanisms::{fixed, run};
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
    for step in [0.1, 0.05] {
        let errors = errors(9, step);
        println!("C6, 9 stages: {errors:?}");
        assert!(errors.iter().all(|&error| error <= 1e-10), "{errors:?}");
    }
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
    for step in [0.1, 0.05] {
        let errors = errors(9, step);
        println!("C3, 9 stages: {errors:?}");
        assert!(errors.iter().all(|&error| error <= 1e-10), "{errors:?}");
    }
}

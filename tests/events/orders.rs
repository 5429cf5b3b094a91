//! The order 2s − 2 of the scheme is kept through events, and so are its floors.

use crate::exact::answer;
use crate::mechanisms::*;
use catena::mechanism::description::mechanism::Mechanism;

/// Errors at the end for some steps, and the slopes between them.
fn slopes(
    mechanism: &Mechanism,
    start: &[f64],
    end: f64,
    wanted: (f64, f64),
    stages: usize,
    steps: &[f64],
) -> (Vec<f64>, Vec<f64>) {
    let errors: Vec<f64> = steps
        .iter()
        .map(|&step| {
            let done = run(mechanism, &at_rest(mechanism, start), end, fixed(stages, step));
            let last = done.state.position.len() - 1;
            (done.state.position[last] - wanted.0).hypot(done.state.velocity[last] - wanted.1)
        })
        .collect();
    let slopes = errors.windows(2).zip(steps.windows(2));
    let slopes = slopes.map(|(error, step)| (error[0] / error[1]).ln() / (step[0] / step[1]).ln()).collect();
    (errors, slopes)
}

#[test]
fn order_is_kept_through_impacts_and_through_rest_and_release() {
    let mut bouncing = pendulum();
    limit(&mut bouncing, 0, -0.3, f64::INFINITY, 0.7);
    let knee = double_pendulum(0.0);
    let (Some(j1), Some(d2)) = (answer("J1"), answer("D2")) else { return };
    let cases = [(&bouncing, vec![1.0], 6.0, (j1[6][1], j1[6][2])), (&knee, vec![0.8, 0.5], 2.5, (d2[7][2], d2[7][4]))];
    for (mechanism, start, end, wanted) in cases {
        for (stages, steps) in [(3, [0.02, 0.01, 0.005, 0.0025]), (5, [0.1, 0.05, 0.025, 0.0125])] {
            let (errors, slopes) = slopes(mechanism, &start, end, wanted, stages, &steps);
            let order = (2 * stages - 2) as f64;
            // A fixed grid has steps of any length before and after an event: slopes scatter, their mean does not by more than half.
            let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
            println!("{} {stages} stages: {errors:?} {slopes:?}", mechanism.bodies.len());
            assert!(mean > order - 0.6 || errors[errors.len() - 1] < 1e-12, "{stages} stages: {errors:?}, {slopes:?}");
        }
        let (errors, _) = slopes(mechanism, &start, end, wanted, 9, &[0.05, 0.025]);
        println!("9 stages {errors:?}");
        assert!(errors.iter().all(|&error| error < 1e-12), "{errors:?}");
    }
}

#[test]
fn order_is_kept_through_reversals_of_friction() {
    let mut mechanism = pendulum();
    friction(&mut mechanism, 0, 0.45);
    // In the middle of the sixth swing.
    let end = 4.3;
    let exact = run(&mechanism, &at_rest(&mechanism, &[1.3]), end, fixed(12, 0.05)).state;
    let wanted = (exact.position[0], exact.velocity[0]);
    for (stages, steps) in [(3, [0.02, 0.01, 0.005, 0.0025]), (5, [0.1, 0.05, 0.025, 0.0125])] {
        let (errors, slopes) = slopes(&mechanism, &[1.3], end, wanted, stages, &steps);
        let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
        println!("{stages} stages: {errors:?} {slopes:?}");
        assert!(mean > (2 * stages - 2) as f64 - 0.6 || errors[3] < 1e-12, "{stages} stages: {errors:?}, {slopes:?}");
    }
}

#[test]
fn events_do_not_depend_on_stages_steps_and_how_the_grid_falls() {
    let mut mechanism = pendulum();
    limit(&mut mechanism, 0, -0.3, 0.9, 0.7);
    friction(&mut mechanism, 0, 0.1);
    let kinds = |stages, step| -> Vec<_> {
        let done = run(&mechanism, &at_rest(&mechanism, &[0.8]), 5.0, fixed(stages, step));
        done.events.iter().map(|event| event.kind).collect()
    };
    let wanted = kinds(9, 0.05);
    assert!(wanted.len() > 5, "{wanted:?}");
    for (stages, step) in [(3, 0.01), (5, 0.05), (5, 0.0333), (9, 0.2), (9, 0.11)] {
        assert_eq!(kinds(stages, step), wanted, "{stages} stages, {step} s");
    }
}

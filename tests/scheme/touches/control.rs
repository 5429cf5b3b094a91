//! Step control, dense output, redundancy and sticking with contacts.

use super::*;
use catena::mechanism::motion::gaps::touch_gaps;

/// A ball that slips on the floor along a parabola, and its place after 0.3 s.
fn billiard() -> (Mechanism, State, Vector3<f64>) {
    let mut mechanism = free(Vector3::new(0.0, 0.0, -9.81), &[(1.0, Vector3::repeat(0.4 * 0.12 * 0.12))]);
    mechanism.touches.push(on_floor(0, Vector3::zeros(), 0.12, slides(0.3)));
    let mut state = State::zero(&mechanism);
    let (velocity, spin) = (Vector3::new(2.0, 0.0, 0.0), Vector3::new(12.0, -10.0, 25.0));
    set(&mut state, 0, [0.0, 0.0, 0.12], Vector3::zeros(), velocity.into(), spin.into());
    let slip = velocity + spin.cross(&Vector3::new(0.0, 0.0, -0.12));
    let end = Vector3::new(0.0, 0.0, 0.12) + velocity * 0.3 - slip / slip.norm() * (0.3 * 9.81 * 0.5 * 0.09);
    (mechanism, state, end)
}

#[test]
fn steps_chosen_for_a_tolerance_meet_it() {
    for tolerance in [1e-6, 1e-9, 1e-11] {
        let (mechanism, mut state, end) = billiard();
        let mut lobatto = Lobatto::adaptive(&mechanism, tolerance);
        while state.time < 0.3 {
            lobatto.advance(&mechanism, &mut state, 0.3).unwrap();
        }
        let error = (Vector3::from_column_slice(&state.position[..3]) - end).norm();
        println!("{tolerance:e}: {error:e}");
        assert!(error < 10.0 * tolerance, "{tolerance:e}: {error:e}");
    }
}

#[test]
fn dense_output_stays_on_the_contact() {
    let (mechanism, mut state, _) = billiard();
    let mut lobatto = Lobatto::fixed(&mechanism, 5, 0.03).unwrap();
    let mut inside = state.clone();
    while state.time < 0.3 {
        let start = state.time;
        lobatto.advance(&mechanism, &mut state, 0.3).unwrap();
        for part in [0.1, 0.37, 0.81] {
            let time = start + part * (state.time - start);
            lobatto.dense(&mechanism, time, &mut inside.position, &mut inside.velocity);
            let (gap, rate) = touch_gaps(&mechanism.touches[0], &body_states(&mechanism, &inside)).largest();
            assert!(gap < 1e-14 && rate < 1e-13, "{gap:e} {rate:e}");
        }
    }
}

#[test]
fn friction_goes_on_smoothly_beyond_the_stop_of_a_slip() {
    // What an event finds the stop on: the step goes on as if friction did not turn round.
    let mut mechanism = free(Vector3::new(0.0, 0.0, -9.81), &[(1.0, Vector3::repeat(0.01))]);
    for (x, y) in [(0.2, 0.2), (-0.2, 0.2), (0.0, -0.2)] {
        mechanism.touches.push(on_floor(0, Vector3::new(x, y, -0.05), 0.0, slides(0.4)));
    }
    let mut state = State::zero(&mechanism);
    set(&mut state, 0, [0.0, 0.0, 0.05], Vector3::zeros(), [1.0, 0.0, 0.0], [0.0; 3]);
    run(&mechanism, &mut state, 5, 1, 0.3);
    let speed = 1.0 - 0.4 * 9.81 * 0.3;
    assert!(speed < -0.1 && (state.velocity[0] - speed).abs() < 1e-13, "{:?}", state.velocity);
}

#[test]
fn a_box_that_rolls_on_its_corners_is_held() {
    let gravity = Vector3::new(3.0, 0.0, -9.0);
    let mut mechanism = free(gravity, &[(1.0, Vector3::repeat(0.01))]);
    for (x, y) in [(0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2)] {
        mechanism.touches.push(on_floor(0, Vector3::new(x, y, -0.05), 0.0, Grip::Rolls));
    }
    let mut state = State::zero(&mechanism);
    set(&mut state, 0, [0.3, 0.0, 0.05], Vector3::zeros(), [0.0; 3], [0.0; 3]);
    let start = state.position.clone();
    run(&mechanism, &mut state, 5, 10, 1.0);
    let moved = state.position.iter().zip(&start).fold(0.0_f64, |most, (now, then)| most.max((now - then).abs()));
    // Twelve equations hold six freedoms.
    assert!(moved < 1e-15 && state.velocity.iter().all(|rate| rate.abs() < 1e-15), "{state:?}");
}

#[test]
fn features_that_make_no_pair_have_no_equation() {
    let mut mechanism = free(Vector3::new(0.0, 0.0, -9.81), &[(1.0, Vector3::repeat(0.01))]);
    let world = feature(None, Vector3::zeros(), Vector3::zeros());
    let body = feature(Some(0), Vector3::zeros(), Vector3::zeros());
    mechanism.touches.push(touch([Feature::Plane, Feature::Plane], slides(0.3), world, body));
    let mut state = State::zero(&mechanism);
    run(&mechanism, &mut state, 5, 4, 1.0);
    assert!((state.position[2] + 0.5 * 9.81).abs() < 1e-13, "{state:?}");
}

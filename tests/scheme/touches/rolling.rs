//! Rolling.

use super::*;

/// A ball of 1 kg that rolls across a slope of tangent 5/12, and its acceleration [m/s²].
fn across_a_slope() -> (Mechanism, State, f64) {
    let inertia = Vector3::repeat(0.4 * 0.12 * 0.12);
    let gravity = Vector3::new(5.0 / 13.0, 0.0, -12.0 / 13.0) * 9.81;
    let mut mechanism = free(gravity, &[(1.0, inertia)]);
    mechanism.touches.push(on_floor(0, Vector3::zeros(), 0.12, Grip::Rolls));
    let mut start = State::zero(&mechanism);
    set(&mut start, 0, [0.0, 0.0, 0.12], Vector3::zeros(), [0.0, 0.5, 0.0], [-0.5 / 0.12, 0.0, 7.0]);
    (mechanism, start, gravity.x / 1.4)
}

#[test]
fn a_ball_rolls_down_an_incline() {
    let (mechanism, start, acceleration) = across_a_slope();
    let until = 0.8;
    let exact = Vector3::new(0.5 * acceleration * until * until, 0.5 * until, 0.12);
    // Along a line with constant acceleration every scheme is exact, however the ball spins about its vertical.
    let error = |state: &State| (Vector3::from_column_slice(&state.position[..3]) - exact).norm();
    let counts = [(3, [16, 32, 64]), (5, [8, 16, 32]), (9, [8, 16, 32])];
    assert_order((&mechanism, &start), until, 1e-14, counts, error);
}

#[test]
fn what_goes_at_its_body_costs_no_iteration() {
    // The mobility of a body alone is known, and its proximal term leaves 1e-8 of a gap: 4.9 iterations a step. With mobilities 1e4 times as large it leaves
    // 1e-4, and takes 5.9.
    let (mechanism, mut state, _) = across_a_slope();
    let ran = run(&mechanism, &mut state, 5, 32, 0.8);
    assert!(ran.iterations < 5.4, "{} iterations", ran.iterations);
}

#[test]
fn a_ball_that_rolls_on_a_drifting_plank_keeps_momentum_and_energy() {
    use catena::mechanism::motion::energy::momentum;
    let inertia = Vector3::repeat(0.4 * 0.12 * 0.12);
    let mut mechanism = free(Vector3::zeros(), &[(2.0, Vector3::new(0.1, 0.2, 0.25)), (1.0, inertia)]);
    let top = feature(Some(0), Vector3::new(0.0, 0.0, 0.05), Vector3::zeros());
    let ball = feature(Some(1), Vector3::zeros(), Vector3::zeros());
    mechanism.touches.push(touch([Feature::Plane, Feature::Point { radius: 0.12 }], Grip::Rolls, top, ball));
    let mut start = State::zero(&mechanism);
    let spin = Vector3::new(0.3, -0.2, 0.5);
    let contact = Vector3::new(0.1, 0.2, 0.05);
    let rolls = Vector3::new(2.0, 3.0, -4.0);
    let velocity = spin.cross(&contact) + rolls.cross(&Vector3::new(0.0, 0.0, 0.12));
    set(&mut start, 0, [0.0; 3], Vector3::zeros(), [0.0; 3], spin.into());
    set(&mut start, 1, [0.1, 0.2, 0.17], Vector3::zeros(), velocity.into(), rolls.into());
    let before = momentum(&mechanism, &body_states(&mechanism, &start));
    let mut ends = Vec::new();
    for (stages, steps) in [(3, 20), (3, 40), (5, 5), (5, 10), (9, 10), (9, 20)] {
        let mut state = start.clone();
        let ran = run(&mechanism, &mut state, stages, steps, 1.0);
        let after = momentum(&mechanism, &body_states(&mechanism, &state));
        let (linear, angular) = ((after.0 - before.0).norm(), (after.1 - before.1).norm());
        println!("s = {stages}, {steps} steps: {linear:.1e}, {angular:.1e}, {:.1} iterations", ran.iterations);
        // Forces act at one point on both bodies: momenta round, and do not truncate.
        assert!(ran.gap < 5e-15 && ran.rate < 5e-14 && linear < 1e-13 && angular < 1e-13);
        assert!(stages < 9 || ran.lost.abs() < 1e-12, "{}", ran.lost);
        ends.push(Vector3::from_column_slice(&state.position[7..10]));
    }
    let error = |run: usize| (ends[run] - ends[5]).norm();
    for (run, order) in [(0, 4.0), (2, 8.0)] {
        let seen = (error(run) / error(run + 1)).log2();
        assert!(seen > order - 0.5, "order {seen} of {order}");
    }
    assert!(error(4) < 1e-13, "{}", error(4));
}

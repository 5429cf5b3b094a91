//! The order of convergence is 2s − 2 (theorem 2.5.2).

use crate::models::{self, Model};
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::stepping::integrator::Lobatto;

fn after(model: &Model, stages: usize, step: f64, time: f64) -> Vec<BodyState> {
    let mut state = model.state.clone();
    let mut lobatto = Lobatto::fixed(&model.mechanism, stages, step).unwrap();
    while state.time < time {
        let outcome = lobatto.advance(&model.mechanism, &mut state, time).unwrap();
        assert_eq!(
            outcome.cost.rejected.total(),
            0,
            "s={stages} h={step}: a step was halved, the order would not be seen"
        );
    }
    body_states(&model.mechanism, &state)
}

/// Observed orders from errors at h and h/2 against a reference of order 16 with steps a quarter as long.
fn check_orders(model: &Model, time: f64, cases: &[(usize, f64)]) {
    let reference = after(model, 9, time / 80.0, time);
    for &(stages, step) in cases {
        let error = |step: f64| models::pose_distance(&after(model, stages, step, time), &reference);
        let (coarse, fine) = (error(step), error(0.5 * step));
        let order = (coarse / fine).log2();
        let expected = (2 * stages - 2) as f64;
        // Half an order of slack: the next term of the error expansion is two orders higher and still visible.
        assert!(
            (order - expected).abs() < 0.5,
            "{} s={stages}: observed order {order:.2} (errors {coarse:.2e}, {fine:.2e}), expected {expected}",
            model.mechanism.name
        );
        assert!(fine > 1e-13, "s={stages}: the finer error {fine:.1e} is rounding and shows no order");
    }
}

#[test]
fn order_is_two_s_minus_two_on_a_double_pendulum_in_space() {
    check_orders(&models::double_pendulum(), 1.0, &[(2, 0.0125), (3, 0.025), (4, 0.05), (5, 0.1)]);
}

#[test]
fn order_is_two_s_minus_two_on_a_floating_tree_with_every_joint_kind() {
    check_orders(&models::floating_tree(), 1.6, &[(2, 0.02), (3, 0.1), (4, 0.2), (5, 0.4)]);
}

#[test]
fn nine_stages_reach_rounding_on_the_double_pendulum() {
    // Steps of 0.1 s and of 0.025 s differ by 1e-9 at order 8 already; at order 16 only rounding is left.
    let model = models::double_pendulum();
    let difference = models::pose_distance(&after(&model, 9, 0.1, 2.0), &after(&model, 9, 0.025, 2.0));
    assert!(difference < 1e-12, "{difference:.1e}");
}

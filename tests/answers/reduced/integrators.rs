//! The integrators of the comparator have their orders, keep to their tolerances, land on the end, and say where they fail.

use super::chain;
use crate::common::run_until;
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::integrator::{Integrator, StepError};
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::reduced::{Dop853, Euler, Rk4};
use nalgebra::Vector3;

/// A double pendulum with crossed axes and a ball joint: every branch of the code, and no symmetry.
fn ball_pendulum() -> (Mechanism, State) {
    let mut mechanism =
        chain(3, 1.0, 1.0, [0.09, 0.07, 0.02], |i| if i == 0 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] });
    mechanism.bodies[1].joint.kind = JointKind::Spherical;
    let mechanism = Mechanism::new("ball pendulum", mechanism.gravity, mechanism.bodies).expect("same order");
    let mut state = State::zero(&mechanism);
    state.displace(&mechanism, &[1.2, 0.4, -0.3, 0.5, -0.7]);
    (mechanism, state)
}

/// Largest distance of the centres of mass from those of a reference.
fn distance(mechanism: &Mechanism, a: &State, b: &State) -> f64 {
    let pairs = body_states(mechanism, a).into_iter().zip(body_states(mechanism, b));
    pairs.map(|(a, b)| (a.position - b.position).norm()).fold(0.0, f64::max)
}

fn observed_order(
    (mechanism, start): (Mechanism, State),
    steps: [f64; 2],
    integrator: impl Fn(&Mechanism, f64) -> Box<dyn Integrator>,
) -> f64 {
    let mut reference = start.clone();
    run_until(&mechanism, &mut reference, &mut Dop853::new(&mechanism, 1e-14), 1.0);
    let errors = steps.map(|step| {
        let mut state = start.clone();
        run_until(&mechanism, &mut state, &mut *integrator(&mechanism, step), 1.0);
        distance(&mechanism, &state, &reference)
    });
    println!("steps {steps:?}: errors {errors:?}");
    (errors[0] / errors[1]).ln() / (steps[0] / steps[1]).ln()
}

#[test]
fn euler_has_order_one() {
    let order = observed_order(ball_pendulum(), [1e-3, 5e-4], |mechanism, step| Box::new(Euler::new(mechanism, step)));
    assert!((order - 1.0).abs() < 0.1, "{order}");
}

#[test]
fn rk4_has_order_four() {
    let order = observed_order(ball_pendulum(), [4e-3, 2e-3], |mechanism, step| Box::new(Rk4::new(mechanism, step)));
    assert!((order - 4.0).abs() < 0.2, "{order}");
}

#[test]
fn dop853_has_order_eight() {
    // Two rods with crossed axes: the light twist of the ball pendulum would need steps where rounding already shows.
    let mechanism = chain(2, 1.0, 1.0, [0.09, 0.09, 0.04], |i| if i == 0 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] });
    let mut start = State::zero(&mechanism);
    start.position.copy_from_slice(&[1.2, -0.7]);
    let steps = [0.05, 0.025];
    let order =
        observed_order((mechanism, start), steps, |mechanism, step| Box::new(Dop853::with_fixed_step(mechanism, step)));
    // The errors are 2e-11 and 9e-14, the finer one with a tenth of rounding in it.
    assert!((order - 8.0).abs() < 0.5, "{order}");
}

#[test]
fn dop853_keeps_to_its_tolerance() {
    let (mechanism, start) = ball_pendulum();
    let mut reference = start.clone();
    run_until(&mechanism, &mut reference, &mut Dop853::new(&mechanism, 1e-14), 2.0);
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        let mut state = start.clone();
        run_until(&mechanism, &mut state, &mut Dop853::new(&mechanism, tolerance), 2.0);
        let error = distance(&mechanism, &state, &reference);
        // Errors of many steps add up and this motion spreads them some hundredfold; a broken estimate is far off.
        assert!(error < 300.0 * tolerance && error > 1e-4 * tolerance, "tolerance {tolerance:e}: {error:e}");
    }
}

#[test]
fn dop853_ends_with_an_error_where_squares_of_speeds_are_infinite() {
    let (mechanism, mut state) = ball_pendulum();
    state.velocity.fill(1e155);
    let mut dop853 = Dop853::new(&mechanism, 1e-6);
    let ended = (0..1000).try_for_each(|_| dop853.advance(&mechanism, &mut state, 1.0).map(drop));
    assert!(ended.is_err());
}

#[test]
fn dop853_at_the_tightest_tolerance_keeps_the_energy() {
    let (mechanism, mut state) = ball_pendulum();
    let summary = run_until(&mechanism, &mut state, &mut Dop853::new(&mechanism, 1e-13), 10.0);
    assert!(summary.max_relative_energy_error < 1e-11, "{:e}", summary.max_relative_energy_error);
    assert!(summary.max_violation.position < 1e-14, "joints hold by construction: {:?}", summary.max_violation);
}

#[test]
fn dense_output_of_dop853_is_as_good_as_its_steps() {
    let (mechanism, start) = ball_pendulum();
    let mut state = start.clone();
    let mut integrator = Dop853::with_fixed_step(&mechanism, 0.02);
    run_until(&mechanism, &mut state, &mut integrator, 0.5);
    for fraction in [0.0, 0.3, 0.7, 1.0] {
        let time = 0.48 + 0.02 * fraction;
        let mut inside = start.clone();
        integrator.dense(&mechanism, time, &mut inside.position, &mut inside.velocity);
        let mut reference = start.clone();
        run_until(&mechanism, &mut reference, &mut Dop853::new(&mechanism, 1e-14), time);
        // Order 7 in a step that makes 1e-10 itself; a cubic would be off by 1e-7.
        let error = distance(&mechanism, &inside, &reference);
        assert!(error < 1e-9, "position at {fraction} of the step: {error:e}");
        let velocities = inside.velocity.iter().zip(&reference.velocity);
        let worst = velocities.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-8, "velocity at {fraction} of the step: {worst:e}");
    }
}

#[test]
fn dense_output_of_the_fixed_step_methods_has_their_order() {
    let (mechanism, start) = ball_pendulum();
    let error = |integrator: &mut dyn Integrator, step: f64| {
        let mut state = start.clone();
        integrator.advance(&mechanism, &mut state, 1.0).expect("a step");
        let mut inside = start.clone();
        integrator.dense(&mechanism, 0.4 * step, &mut inside.position, &mut inside.velocity);
        let mut reference = start.clone();
        run_until(&mechanism, &mut reference, &mut Dop853::new(&mechanism, 1e-14), 0.4 * step);
        distance(&mechanism, &inside, &reference)
    };
    let ratio = |coarse: f64, fine: f64| (coarse / fine).log2();
    let rk4 = ratio(error(&mut Rk4::new(&mechanism, 0.04), 0.04), error(&mut Rk4::new(&mechanism, 0.02), 0.02));
    assert!(rk4 > 3.7, "inside a single step of order four: {rk4}");
    let euler = ratio(error(&mut Euler::new(&mechanism, 4e-3), 4e-3), error(&mut Euler::new(&mechanism, 2e-3), 2e-3));
    assert!(euler > 1.8, "inside a single step of order one: {euler}");
}

#[test]
fn every_integrator_lands_exactly_on_the_end() {
    let (mechanism, start) = ball_pendulum();
    let integrators: [Box<dyn Integrator>; 4] = [
        Box::new(Euler::new(&mechanism, 0.01)),
        Box::new(Rk4::new(&mechanism, 0.01)),
        Box::new(Dop853::new(&mechanism, 1e-8)),
        Box::new(Dop853::with_fixed_step(&mechanism, 0.01)),
    ];
    for mut integrator in integrators {
        let mut state = start.clone();
        let summary = run_until(&mechanism, &mut state, &mut *integrator, 0.3);
        assert_eq!(state.time, 0.3, "{:?}", integrator.description());
        if !integrator.description().adaptive {
            assert_eq!(summary.steps, 30, "no sliver of a step is left: {:?}", integrator.description());
        }
        let norm: f64 = state.joint_position(&mechanism, 1).iter().map(|c| c * c).sum();
        assert!((norm - 1.0).abs() < 4.0 * f64::EPSILON, "quaternions are of unit length: {norm}");
    }
}

#[test]
fn a_state_changed_between_steps_is_noticed() {
    let (mechanism, start) = ball_pendulum();
    let mut integrator = Dop853::new(&mechanism, 1e-10);
    let mut state = start.clone();
    integrator.advance(&mechanism, &mut state, 1.0).expect("a step");
    state = start.clone();
    state.velocity[0] = 1.0;
    let mut fresh = state.clone();
    run_until(&mechanism, &mut state, &mut integrator, 0.2);
    run_until(&mechanism, &mut fresh, &mut Dop853::new(&mechanism, 1e-10), 0.2);
    assert_eq!(state, fresh);
}

#[test]
fn failures_name_the_time_and_the_joint() {
    // A massless leaf has no acceleration.
    let mut mechanism = chain(2, 1.0, 1.0, [0.1, 0.1, 0.1], |_| [0.0, 1.0, 0.0]);
    mechanism.bodies[1].mass = 0.0;
    mechanism.bodies[1].inertia = Vector3::zeros();
    let integrators: [Box<dyn Integrator>; 3] = [
        Box::new(Euler::new(&mechanism, 0.01)),
        Box::new(Rk4::new(&mechanism, 0.01)),
        Box::new(Dop853::new(&mechanism, 1e-8)),
    ];
    for mut integrator in integrators {
        let mut state = State::zero(&mechanism);
        let before = state.clone();
        match integrator.advance(&mechanism, &mut state, 1.0) {
            Err(StepError::NotFinite { time, joint, .. }) => {
                assert!(time == 0.0 && joint == "joint1", "{time} {joint}");
            }
            other => panic!("{other:?}"),
        }
        assert_eq!(state, before, "the state stays that of the last accepted step");
    }
    // No step is short enough for a tolerance under the rounding of a double.
    let (mechanism, mut state) = ball_pendulum();
    let failure = Dop853::new(&mechanism, 1e-40).advance(&mechanism, &mut state, 1.0);
    assert!(matches!(failure, Err(StepError::NotConverged { time: 0.0, .. })), "{failure:?}");
}

//! What holds whatever the numbers: true sticking, energy, simultaneous limits, starts on limits, tolerances.

use crate::exact::answer;
use crate::mechanisms::*;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::event::EventKind;
use catena::output::report::{AccuracyReport, Horizon};
use catena::session::Model;
use catena::simulation::method::run_integrator::RunIntegrator;
use catena::simulation::{Simulation, SimulationOptions, StepChoice};
use catena::stepping::length::stage_choice::StageChoice;
use catena::stepping::recipe::Steps;
use nalgebra::Vector3;

/// The effort that holds the pendulum still at an angle.
fn weight(angle: f64) -> f64 {
    2.0 * GRAVITY * 0.5 * angle.sin()
}

#[test]
fn a_joint_below_its_friction_has_no_rate_at_all_and_one_above_it_slides() {
    let start = 0.4_f64;
    for (share, moves) in [(0.999, false), (1.001, true)] {
        let mut mechanism = pendulum();
        friction(&mut mechanism, 0, weight(start) / share);
        let done = run(&mechanism, &at_rest(&mechanism, &[start]), 100.0, fixed(3, 1e-4));
        let still = done.state.position[0] == start && done.state.velocity[0] == 0.0;
        assert_eq!(!still, moves, "{share}: {:?}", done.state);
        // What friction holds is not simulated until something changes: one step to the end.
        assert_eq!(done.summary.steps == 1, !moves, "{:?}", done.summary);
    }
}

#[test]
fn a_link_that_friction_holds_on_a_moving_arm_has_no_rate_in_a_hundred_thousand_steps() {
    // The knee is stuck by much friction while the hip swings: its angle stays the same to the last bit.
    let mut mechanism = double_pendulum(0.0);
    mechanism.nonsmooth.limits.clear();
    friction(&mut mechanism, 1, 40.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.8, 0.5]), 1000.0, fixed(5, 0.01));
    assert_eq!((done.state.position[1], done.state.velocity[1]), (0.5, 0.0));
    assert!(done.events.is_empty());
    assert!(done.summary.max_relative_energy_error < 1e-9, "{:?}", done.summary);
}

#[test]
#[ignore = "half a minute: cargo test --release --test events million -- --ignored --nocapture"]
fn a_joint_at_0_999_of_its_friction_has_no_rate_in_a_million_steps_of_a_wheel_that_it_carries() {
    // The wheel turns about its centre of mass, so that its weight is all that the joint feels of it.
    let angle = 0.4_f64;
    let carrier = hinge("hinge", None, Vector3::zeros(), 0.5, 2.0, 0.02);
    let wheel = hinge("axle", Some(0), Vector3::zeros(), 0.0, 1.0, 0.01);
    let mut mechanism = mechanism(vec![carrier, wheel]);
    friction(&mut mechanism, 0, 1.5 * weight(angle) / 0.999);
    let mut start = at_rest(&mechanism, &[angle, 0.0]);
    start.velocity[1] = 5.0;
    let done = run(&mechanism, &start, 1e4, fixed(3, 0.01));
    println!("{} steps: {:?}", done.summary.steps, done.state);
    assert_eq!(done.summary.steps, 1_000_000);
    assert_eq!((done.state.position[0], done.state.velocity[0]), (angle, 0.0));
    assert!(done.events.is_empty());
}

#[test]
fn a_motion_on_which_runs_meet_other_events_says_from_when_it_is_not_determined() {
    // Impacts between two limits of each joint part neighbouring motions within seconds.
    let mut mechanism = double_pendulum(1.0);
    mechanism.nonsmooth.limits.clear();
    limit(&mut mechanism, 0, -0.7, 0.9, 1.0);
    limit(&mut mechanism, 1, -0.5, 0.6, 1.0);
    let start = at_rest(&mechanism, &[0.8, 0.35]);
    let told = |duration: f64| {
        let options = SimulationOptions::new(duration, StepChoice::Tolerance(1e-6));
        let mut simulation = Simulation::new(&mechanism, start.clone(), options).expect("a simulation");
        simulation.run().expect("a run");
        let finished = simulation.finish();
        let report = AccuracyReport::of(options.steps, &finished).expect("an accuracy");
        (finished.accuracy[0].clone().expect("an accuracy"), report)
    };
    let (calm, report) = told(1.0);
    assert_eq!((calm.events_differ, calm.holds_until, report.horizon), (None, 1.0, None));
    assert_eq!(report.warning(), None);
    let (found, report) = told(60.0);
    println!("{found:?}");
    let differ = found.events_differ.expect("another order of events");
    assert!(differ > 1.0 && differ < 60.0 && found.holds_until <= differ);
    assert_eq!(report.horizon, Some(Horizon::Events));
    assert!(report.warning().is_some_and(|warning| warning.contains("runs that differ by little meet other events")));
}

#[test]
fn elastic_limits_keep_the_energy_of_a_double_pendulum_over_a_thousand_impacts() {
    let mut mechanism = double_pendulum(1.0);
    mechanism.nonsmooth.limits.clear();
    limit(&mut mechanism, 0, -0.7, 0.9, 1.0);
    limit(&mut mechanism, 1, -0.5, 0.6, 1.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.8, 0.5]), 400.0, fixed(9, 0.02));
    let impacts = done.summary.events.of(EventKind::LimitImpact);
    assert!(impacts > 1000, "{impacts}");
    assert!(done.summary.max_relative_energy_error < 1e-11, "{:?}", done.summary);
}

#[test]
#[ignore = "some minutes: cargo test --release --test events -- --ignored"]
fn elastic_limits_keep_the_energy_over_a_hundred_thousand_impacts() {
    let mut mechanism = double_pendulum(1.0);
    mechanism.nonsmooth.limits.clear();
    limit(&mut mechanism, 0, -0.7, 0.9, 1.0);
    limit(&mut mechanism, 1, -0.5, 0.6, 1.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.8, 0.5]), 1.4e4, fixed(9, 0.02));
    println!("{} impacts, {:?}", done.summary.events.of(EventKind::LimitImpact), done.summary);
    assert!(done.summary.events.of(EventKind::LimitImpact) > 100_000);
    assert!(done.summary.max_relative_energy_error < 1e-9, "{:?}", done.summary);
}

#[test]
fn what_leaves_its_limit_with_no_speed_is_not_met_again_at_once() {
    // On the limit at rest, and pulled away from it by a growing effort.
    let mut mechanism = pendulum();
    limit(&mut mechanism, 0, 0.0, 2.0, 0.5);
    let target = Target::table(&[(0.0, -1.0), (1.0, 1.0)], Default::default()).expect("a table");
    motor(&mut mechanism, 0, MotorLaw::Effort, target, f64::INFINITY, 0.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.0]), 0.9, fixed(5, 0.05));
    let kinds: Vec<EventKind> = done.events.iter().map(|event| event.kind).collect();
    assert_eq!(kinds, [EventKind::Release], "{:?}", done.events);
    assert!((done.events[0].time - 0.5).abs() < 1e-12);
}

#[test]
fn a_start_that_runs_into_its_limit_is_an_impact_at_the_start() {
    let mut mechanism = pendulum();
    limit(&mut mechanism, 0, 0.0, 2.0, 0.5);
    let mut start = at_rest(&mechanism, &[0.0]);
    start.velocity[0] = -2.0;
    let done = run(&mechanism, &start, 0.1, fixed(9, 0.05));
    assert_eq!((done.events[0].kind, done.events[0].time), (EventKind::LimitImpact, 0.0));
    assert!((done.events[0].impulse.expect("of an impact") - 0.52 * 3.0).abs() < 1e-14);
    assert!((done.summary.exchange.impacts - 0.5 * 0.52 * (4.0 - 1.0)).abs() < 1e-14);
}

#[test]
fn a_joint_whose_limits_leave_no_room_does_not_move() {
    let mut mechanism = double_pendulum(0.0);
    mechanism.nonsmooth.limits.clear();
    limit(&mut mechanism, 1, 0.5, 0.5, 0.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[0.8, 0.5]), 3.0, fixed(5, 0.05));
    assert_eq!((done.state.position[1], done.state.velocity[1]), (0.5, 0.0));
    assert!(done.events.is_empty(), "{:?}", done.events);
}

#[test]
fn a_tolerance_counts_what_events_do_to_errors() {
    let (Some(j1), Some(j2)) = (answer("J1"), answer("J2")) else { return };
    let mut mechanism = pendulum();
    limit(&mut mechanism, 0, -0.3, f64::INFINITY, 0.7);
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let done = run(&mechanism, &at_rest(&mechanism, &[1.0]), 6.0, StepChoice::Tolerance(tolerance));
        let error = (done.state.position[0] - j1[6][1]).abs();
        assert!(error < tolerance, "{tolerance}: off by {error:e}");
        assert_eq!(done.events.len(), 6);
    }
    let mut mechanism = pendulum();
    friction(&mut mechanism, 0, 0.45);
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let done = run(&mechanism, &at_rest(&mechanism, &[1.3]), 12.0, StepChoice::Tolerance(tolerance));
        let error = (done.state.position[0] - j2[12][1]).abs();
        assert!(error < tolerance, "{tolerance}: off by {error:e}");
        assert_eq!(done.events.len(), 13);
    }
}

#[test]
fn a_run_that_is_made_twice_is_the_same_to_the_last_bit() {
    let mut mechanism = double_pendulum(0.4);
    friction(&mut mechanism, 0, 0.3);
    friction(&mut mechanism, 1, 0.2);
    let once = || run(&mechanism, &at_rest(&mechanism, &[0.8, 0.5]), 3.0, fixed(5, 0.03));
    let (first, second) = (once(), once());
    assert_eq!(first.state, second.state);
    assert_eq!(first.events, second.events);
}

#[test]
fn what_friction_holds_is_let_go_when_somebody_pushes_harder_than_it_bears() {
    let mut mechanism = mechanism(vec![slide("rail", nalgebra::Vector3::x(), 2.0)]);
    friction(&mut mechanism, 0, 3.0);
    let options = SimulationOptions::new(3.0, fixed(5, 0.1));
    let mut simulation = Simulation::new(&mechanism, at_rest(&mechanism, &[0.0]), options).expect("a run");
    for (push, until, rate) in [(2.9, 1.0, 0.0), (5.0, 2.0, 1.0), (0.0, 2.5, 0.25)] {
        simulation.set_efforts(&[push]).expect("an effort");
        simulation.step_to(until).expect("steps");
        assert!((simulation.state().velocity[0] - rate).abs() < 1e-13, "{push} N: {:?}", simulation.state());
    }
    simulation.run().expect("to the end");
    // Half a second of 1.5 m/s² has taken the quarter of a metre per second that was left.
    assert_eq!(simulation.state().velocity[0], 0.0);
    assert!((simulation.state().position[0] - (0.5 + 1.0 / 3.0)).abs() < 1e-13, "{:?}", simulation.state());
}

#[test]
fn motions_with_events_carry_a_companion_unless_loops_close() {
    let steps = Steps::Chosen { tolerance: 1e-6, stop: 1e-9, stages: StageChoice::Many };
    let carries =
        |mechanism: &Mechanism| RunIntegrator::new(mechanism, steps, &[]).expect("steps").accompany(mechanism);
    let mut tree = double_pendulum(1.0);
    limit(&mut tree, 0, -0.7, 0.9, 1.0);
    assert!(carries(&tree));
    // In closed loops the errors of iterations, which a companion shows, are negligible beside those of the length of steps.
    let file = format!("{}/robots/four_bar_1.toml", env!("CARGO_MANIFEST_DIR"));
    let mut closed = Model::load(file).expect("a scene").description().mechanism.clone();
    limit(&mut closed, 0, -3.0, 3.0, 1.0);
    assert!(closed.has_closures() && !carries(&closed));
}

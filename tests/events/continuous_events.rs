//! Controllers that act at every instant beside limits, dry friction, motors and contacts.

use crate::contacts::{over_floor, placed};
use crate::continuous::{Hold, run_under};
use crate::mechanisms::*;
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::{Interpolation, Target};
use catena::mechanism::motion::event::{Event, EventKind};
use catena::mechanism::motion::state::State;
use catena::simulation::{ContinuousController, StepChoice};
use nalgebra::{DMatrix, Vector3};

/// A law of one freedom: `u(t, x, v)` with its derivatives by x and v.
struct Along<F: Fn(f64, f64, f64) -> [f64; 3]> {
    freedom: usize,
    law: F,
}

impl<F: Fn(f64, f64, f64) -> [f64; 3]> Along<F> {
    fn at(&self, state: &State) -> [f64; 3] {
        let at = self.freedom;
        (self.law)(state.time, state.position[at] + state.compensation[at], state.velocity[at])
    }
}

impl<F: Fn(f64, f64, f64) -> [f64; 3]> ContinuousController for Along<F> {
    fn freedoms(&self, _: &Mechanism) -> Vec<usize> {
        vec![self.freedom]
    }

    fn efforts(&self, _: &Mechanism, state: &State, efforts: &mut [f64]) {
        efforts[0] = self.at(state)[0];
    }

    fn derivatives(&self, _: &Mechanism, state: &State, positions: &mut DMatrix<f64>, velocities: &mut DMatrix<f64>) {
        let [_, by_position, by_velocity] = self.at(state);
        positions[(0, self.freedom)] = by_position;
        velocities[(0, self.freedom)] = by_velocity;
    }
}

/// The largest difference of positions and velocities.
fn apart(one: &State, other: &State) -> f64 {
    let positions = one.position.iter().zip(&other.position);
    let velocities = one.velocity.iter().zip(&other.velocity);
    positions.chain(velocities).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}

/// A double pendulum with limits at both joints and dry friction in both.
fn limited() -> Mechanism {
    let mut mechanism = double_pendulum(0.5);
    friction(&mut mechanism, 0, 0.3);
    friction(&mut mechanism, 1, 0.2);
    mechanism
}

#[test]
fn events_under_a_continuous_law_are_those_under_the_built_in_motor() {
    let mechanism = limited();
    let start = at_rest(&mechanism, &[1.2, 0.4]);
    let (kp, kd) = (6.0, 0.2);
    let law = Hold { kp, kd, target: -0.7, told: 1.0 };
    let mut with_motors = mechanism.clone();
    for body in 0..2 {
        motor(&mut with_motors, body, MotorLaw::Position { kp, kd }, Target::constant(-0.7), f64::INFINITY, 0.0);
    }
    let found = run_under(&mechanism, &start, 4.0, fixed(5, 0.01), &law).unwrap();
    let wanted = run(&with_motors, &start, 4.0, fixed(5, 0.01));
    let of = |events: &[Event]| events.iter().map(|event| (event.kind, event.body)).collect::<Vec<_>>();
    println!("{} events, apart {:e}", wanted.events.len(), apart(&found.state, &wanted.state));
    for kind in [EventKind::LimitImpact, EventKind::Stick] {
        assert!(wanted.events.iter().any(|event| event.kind == kind), "no {kind:?}: the test shows nothing");
    }
    assert_eq!(of(&found.events), of(&wanted.events));
    for (found, wanted) in found.events.iter().zip(&wanted.events) {
        // Both are the same equations, solved to rounding.
        assert!((found.time - wanted.time).abs() < 1e-11, "{found:?}, {wanted:?}");
    }
    assert!(apart(&found.state, &wanted.state) < 1e-11);
    let [found, wanted] = [&found.summary, &wanted.summary].map(|summary| summary.max_relative_energy_error);
    // The work of the law is counted as that of the motor.
    assert!(found < 2.0 * wanted + 1e-12, "{found:e}, {wanted:e}");
}

#[test]
fn a_law_of_time_lets_go_of_a_stuck_joint_at_the_instant_when_it_exceeds_the_friction() {
    let mut mechanism = mechanism(vec![slide("rail", Vector3::x(), 1.0)]);
    friction(&mut mechanism, 0, 2.0);
    let start = at_rest(&mechanism, &[0.0]);
    let law = Along { freedom: 0, law: |time, _, _| [0.8 * time, 0.0, 0.0] };
    for steps in [fixed(3, 0.05), fixed(9, 0.3), StepChoice::Tolerance(1e-9)] {
        let done = run_under(&mechanism, &start, 4.0, steps, &law).unwrap();
        let slips = of_kind(&done, EventKind::Slip);
        assert_eq!(slips.len(), 1, "{:?}", done.events);
        // 0.8 t = 2; then x = 0.4/3 (t − 2.5)³: cubic, which three stages solve exactly.
        assert!((slips[0].time - 2.5).abs() < 1e-11, "{:e}", slips[0].time - 2.5);
        assert!((done.state.position[0] - 0.4 / 3.0 * 1.5_f64.powi(3)).abs() < 1e-10, "{:?}", done.state.position);
        assert!((done.state.velocity[0] - 0.4 * 1.5_f64.powi(2)).abs() < 1e-10);
    }
    let held = run_under(&mechanism, &start, 2.4, fixed(3, 0.05), &law).unwrap();
    assert_eq!((held.state.position[0], held.state.velocity[0]), (0.0, 0.0));
}

#[test]
fn a_law_and_a_motor_whose_target_changes_act_on_one_joint_together() {
    let mut one = mechanism(vec![slide("rail", Vector3::x(), 1.0)]);
    limit(&mut one, 0, -0.2, 0.35, 0.6);
    let start = at_rest(&one, &[0.1]);
    // A push that grows like t and a spring with damping: by a motor and a law, and by a law alone.
    let (k, d) = (30.0, 0.5);
    let push = Target::table(&[(0.0, 0.0), (10.0, 40.0)], Interpolation::Linear).unwrap();
    let mut with_motor = one.clone();
    motor(&mut with_motor, 0, MotorLaw::Effort, push, f64::INFINITY, 0.0);
    let spring = Along { freedom: 0, law: |_, x, v| [-k * x - d * v, -k, -d] };
    let all = Along { freedom: 0, law: |time, x, v| [4.0 * time - k * x - d * v, -k, -d] };
    let found = run_under(&with_motor, &start, 3.0, fixed(5, 0.01), &spring).unwrap();
    let wanted = run_under(&one, &start, 3.0, fixed(5, 0.01), &all).unwrap();
    assert!(!of_kind(&wanted, EventKind::LimitImpact).is_empty(), "{:?}", wanted.events);
    assert_eq!(found.events.len(), wanted.events.len());
    assert!(apart(&found.state, &wanted.state) < 1e-11, "{:e}", apart(&found.state, &wanted.state));
}

#[test]
fn a_box_on_a_floor_under_a_law_sticks_where_a_slider_with_the_same_friction_does() {
    let gravity = Vector3::new(0.0, 0.0, -GRAVITY);
    let half = Vector3::new(0.2, 0.2, 0.05);
    let shapes = vec![(Shape::Box { half }, Pose::identity())];
    let block = over_floor(1.0, Vector3::new(0.0142, 0.0142, 0.0267), shapes, gravity, 0.3, 0.0);
    let on_floor = placed(&block, Vector3::new(0.5, 0.0, 0.05), Vector3::zeros(), Vector3::zeros());
    let law = Along { freedom: 0, law: |_, x, v| [-40.0 * x - 0.8 * v, -40.0, -0.8] };
    let found = run_under(&block, &on_floor, 3.0, fixed(5, 0.01), &law).unwrap();
    let mut slider = mechanism(vec![slide("rail", Vector3::x(), 1.0)]);
    friction(&mut slider, 0, 0.3 * GRAVITY);
    let wanted = run_under(&slider, &at_rest(&slider, &[0.5]), 3.0, fixed(5, 0.01), &law).unwrap();
    assert_eq!(wanted.state.velocity[0], 0.0, "it sticks in the end");
    println!("{} and {}: {:?}", found.state.position[0], wanted.state.position[0], found.events);
    // A slip of the box stops to 1e-10 of its fastest, 2 m/s.
    assert!((found.state.position[0] - wanted.state.position[0]).abs() < 1e-9);
    assert!(found.state.velocity.iter().all(|rate| rate.abs() < 1e-12), "{:?}", found.state.velocity);
    assert!((found.state.position[2] - 0.05).abs() < 1e-12);
}

#[test]
fn order_is_kept_through_events_under_a_law_that_acts_at_every_instant() {
    let mut mechanism = pendulum();
    limit(&mut mechanism, 0, -0.4, 0.9, 0.7);
    friction(&mut mechanism, 0, 0.15);
    let start = at_rest(&mechanism, &[0.8]);
    // A pendulum whose law is not linear: a negative damper about a cycle, as of van der Pol.
    let law =
        Along { freedom: 0, law: |_, x, v| [3.0 * (0.5 - 4.0 * x * x) * v, -24.0 * x * v, 3.0 * (0.5 - 4.0 * x * x)] };
    let at = |stages: usize, step: f64| run_under(&mechanism, &start, 1.5, fixed(stages, step), &law).unwrap();
    let wanted = at(9, 0.01);
    for kind in [EventKind::LimitImpact, EventKind::Reversal] {
        assert!(!of_kind(&wanted, kind).is_empty(), "no {kind:?}: {:?}", wanted.events);
    }
    for (stages, steps) in [(3, [0.02, 0.01, 0.005]), (5, [0.1, 0.05, 0.025])] {
        let errors = steps.map(|step| apart(&at(stages, step).state, &wanted.state));
        let slope = (errors[0] / errors[2]).log2() / 2.0;
        println!("{stages} stages: {errors:?}, slope {slope}");
        // Where events fall within steps scatters the errors.
        assert!(slope > (2 * stages - 2) as f64 - 1.0, "{stages} stages: {errors:?}, slope {slope}");
    }
    let nine = apart(&at(9, 0.05).state, &wanted.state);
    println!("9 stages: {nine:e}");
    assert!(nine < 1e-10, "{nine:e}");
}

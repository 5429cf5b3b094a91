//! What rests in equilibrium is known, and neither moves nor costs a step.

use super::{Way, parts, pendulum, run_islands, side_by_side, spring_between};
use crate::models::Model;
use crate::{closed, common, models};
use catena::instant::exerting::rest::is_at_rest;
use catena::mechanism::description::forces::{JointLoad, PointSpring};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::energy::{energy, energy_with_forces};
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::simulation::RunOptions;
use catena::simulation::parallel::partition::Plan;
use catena::stepping::integrator::Lobatto;
use nalgebra::Vector3;

#[test]
fn rest_in_equilibrium_is_known_stable_or_not_and_nothing_else_is() {
    let rests = |(mechanism, state): (Mechanism, State)| is_at_rest(&mechanism, &state);
    assert!(rests(pendulum(0.0)), "hanging");
    assert!(rests(pendulum(std::f64::consts::PI)), "exactly upright, which π is to rounding");
    assert!(!rests(pendulum(1e-9)) && !rests(pendulum(std::f64::consts::PI - 1e-9)), "beside an equilibrium");
    assert!(!rests(pendulum(std::f64::consts::FRAC_PI_2)), "horizontal");
    let (mechanism, mut moving) = pendulum(0.0);
    moving.velocity[0] = 1e-300;
    assert!(!is_at_rest(&mechanism, &moving), "on its way through the equilibrium");

    let mut hanging = pendulum(0.0);
    hanging.0.forces.point_springs.push(PointSpring { rest_length: 1.0, damping: 0.0, ..spring_between(0, 0) });
    hanging.0.forces.point_springs[0].a = models::point_of(None, [0.0, 0.0, -3.0]);
    hanging.0.forces.point_springs[0].b = models::point_of(Some(0), [0.0, 0.0, -0.5]);
    assert!(rests(hanging.clone()), "pulled straight down");
    hanging.0.forces.point_springs[0].a = models::point_of(None, [0.1, 0.0, -3.0]);
    assert!(!rests(hanging), "pulled aside");

    let mut free = parts(models::free_body());
    free.1.velocity.fill(0.0);
    assert!(!rests(free.clone()), "falling");
    free.0.gravity = Vector3::zeros();
    assert!(rests(free.clone()), "in empty space");
    let turned = models::wrenches(&free.0).wrenches[0];
    free.0.forces.wrenches = vec![catena::mechanism::description::forces::Wrench { force: Vector3::zeros(), ..turned }];
    assert!(!rests(free), "turned by a torque");

    // A square four-bar is in equilibrium when it hangs straight down, loops and all, and not when it leans.
    let lean = |angle: f64| {
        let (mechanism, mut state) = closed::four_bars(1, 5);
        state.velocity.fill(0.0);
        state.position.copy_from_slice(&[-angle, angle, -angle]);
        (mechanism, state)
    };
    assert!(rests(lean(std::f64::consts::FRAC_PI_2)), "hanging four-bar");
    assert!(!rests(lean(1.0)), "leaning four-bar");
}

#[test]
fn what_has_inertia_but_no_mass_is_at_rest_only_where_nothing_turns_it() {
    let (mut mechanism, state) = pendulum(0.0);
    mechanism.bodies[0].mass = 0.0;
    assert!(is_at_rest(&mechanism, &state), "without effort");
    mechanism.forces.joint_loads.push(JointLoad { freedom: 0, effort: 1e-20 });
    assert!(!is_at_rest(&mechanism, &state), "a driven rotor");
}

#[test]
fn no_gravity_is_so_strong_or_weak_that_what_it_pulls_aside_is_at_rest() {
    // The squares of these are infinite and zero.
    for pull in [1e200, 1e-200] {
        let (mut mechanism, state) = pendulum(0.0);
        mechanism.gravity = Vector3::new(pull, 0.0, 0.0);
        assert!(!is_at_rest(&mechanism, &state), "{pull} m/s²");
    }
}

#[test]
fn a_sleeping_island_stays_exactly_where_it_is_and_the_others_do_not_notice() {
    let model = side_by_side(vec![
        pendulum(0.0),
        parts(models::double_pendulum()),
        pendulum(std::f64::consts::PI),
        parts(models::chain(3)),
    ]);
    let plan = Plan::new(&model.mechanism, &model.state, &[]);
    assert_eq!((plan.islands.len(), plan.sleeping()), (4, 2));
    let options = RunOptions { duration: 1.0, rate: Some(50.0), interrupt: None };
    let (state, summary, seen) = run_islands(&model, Way::Fixed(5, 0.01), &options, 2);
    assert_eq!(summary.steps, 200, "two of four make steps");
    assert_eq!((state.position[0], state.position[3]), (0.0, std::f64::consts::PI));
    assert_eq!(seen.samples.len(), 51);
    for (time, position, velocity) in &seen.samples {
        assert_eq!((position[0], velocity[0], position[3]), (0.0, 0.0, std::f64::consts::PI), "t = {time}");
    }
    let mut alone = models::double_pendulum();
    let mut lobatto = Lobatto::fixed(&alone.mechanism, 5, 0.01).expect("five stages");
    common::run_until(&alone.mechanism, &mut alone.state, &mut lobatto, 1.0);
    assert_eq!(state.position[1..3], alone.state.position);
    let bodies = body_states(&model.mechanism, &state);
    assert_eq!(summary.final_energy, energy_with_forces(&model.mechanism, &state.position, &bodies));
    assert_eq!(summary.final_energy, energy(&model.mechanism, &bodies));
}

#[test]
fn what_sleeps_altogether_is_shown_all_the_same() {
    let model = side_by_side(vec![pendulum(0.0), pendulum(0.0)]);
    for (rate, expected) in [(Some(10.0), 21), (None, 2)] {
        let options = RunOptions { duration: 2.0, rate, interrupt: None };
        let (state, summary, seen) = run_islands(&model, Way::Tolerance(1e-6), &options, 2);
        assert_eq!((summary.steps, state.time, seen.samples.len()), (0, 2.0, expected));
        assert_eq!(seen.samples[expected - 1].0, 2.0);
    }
}

#[test]
fn a_rule_that_is_switched_off_does_not_apply() {
    let model = side_by_side(vec![pendulum(0.0), parts(models::double_pendulum())]);
    let counts = |kept: &[Rule]| {
        let plan = Plan::new(&model.mechanism, &model.state, kept);
        (plan.islands.len(), plan.sleeping(), plan.is_whole())
    };
    assert_eq!(counts(&[]), (2, 1, false));
    assert_eq!(counts(&[Rule::Sleep]), (2, 0, false));
    assert_eq!(counts(&[Rule::Islands]), (1, 0, true), "the whole moves");
    let Model { mechanism, state } = models::double_pendulum();
    assert!(Plan::new(&mechanism, &state, &[]).is_whole(), "one robot that moves is run as it always was");
}

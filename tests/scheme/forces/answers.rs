//! Springs, dampers and loads do what formulas and a published table say.

#![allow(clippy::excessive_precision, reason = "reference values stand as their source prints them")]

use super::{damper, fixed, one_body, run};
use crate::models::{self, Model};
use catena::mechanism::description::closure::Coordinate;
use catena::mechanism::description::forces::{Forces, JointLoad, JointSpring, PointSpring, Wrench};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

fn spring(stiffness: f64, rest: f64) -> Vec<JointSpring> {
    vec![JointSpring { coordinate: Coordinate { body: 0, position: 0, freedom: 0 }, stiffness, rest }]
}

#[test]
fn damped_pendulum_follows_the_published_table() {
    // Section "energy dissipation" of the page of benchmark problems: angle and rate at 1, 2, 5 and 10 s.
    let table = [
        (1.0, -0.73122567768158586, 0.57073028916348334),
        (2.0, 0.2915486281878607, -0.88727674890636288),
        (5.0, 0.026216375666740198, 0.073999133899616515),
        (10.0, 0.00058422150430570169, 0.0019268141383425202),
    ];
    let mut model =
        one_body(JointKind::Revolute, 0.5, 9.81, Forces { joint_dampers: damper(0.5), ..Forces::default() });
    model.state.position[0] = std::f64::consts::FRAC_PI_2;
    for (time, angle, rate) in table {
        let (end, _) = run(&model, &mut fixed(&model, 9, 0.05), time);
        let errors = [(end.position[0] - angle).abs(), (end.velocity[0] - rate).abs()];
        println!("t = {time}: {errors:?}");
        // The table is good to 15 digits; ours to a few hundred roundings.
        assert!(errors[0] < 1e-12 && errors[1] < 1e-12, "t = {time}: {errors:?}");
    }
}

#[test]
fn damped_oscillator_follows_its_formula_below_and_above_critical_damping() {
    let (stiffness, rest, start) = (40.0_f64, 0.3, 1.1);
    for coefficient in [0.0, 2.0, 30.0] {
        let forces =
            Forces { joint_dampers: damper(coefficient), joint_springs: spring(stiffness, rest), ..Forces::default() };
        let mut model = one_body(JointKind::Prismatic, 0.2, 9.81, forces);
        model.state.position[0] = start;
        let (end, summary) = run(&model, &mut fixed(&model, 9, 0.1), 2.0);
        // x'' = −c x' − k x from rest, for one kilogram.
        let (half, time) = (0.5 * coefficient, 2.0);
        let offset = start - rest;
        let expected = if half * half < stiffness {
            let omega = (stiffness - half * half).sqrt();
            offset * (-half * time).exp() * ((omega * time).cos() + half / omega * (omega * time).sin())
        } else {
            let root = (half * half - stiffness).sqrt();
            let (fast, slow) = (-half - root, -half + root);
            offset * (fast * (slow * time).exp() - slow * (fast * time).exp()) / (fast - slow)
        };
        let error = (end.position[0] - rest - expected).abs();
        println!("c = {coefficient}: {error:.1e}, balance {:.1e}", summary.max_relative_energy_error);
        // Fifteen orders of a step of 0.6 to 3 natural units.
        assert!(error < 1e-11, "c = {coefficient}: {error:.1e}");
    }
}

#[test]
fn joint_spring_counts_full_turns() {
    // Wound up by ten radians, three turns of swing: a harmonic motion for one who counts them.
    let forces = Forces { joint_springs: spring(0.9, 0.0), ..Forces::default() };
    let mut model = one_body(JointKind::Revolute, 0.0, 0.0, forces);
    model.state.position[0] = 10.0;
    let omega = (0.9 / model.mechanism.bodies[0].inertia.y).sqrt();
    let (end, _) = run(&model, &mut fixed(&model, 9, 0.02), 3.0);
    let error = (end.position[0] - 10.0 * (3.0 * omega).cos()).abs();
    assert!(error < 1e-11, "{error:.1e}");
}

#[test]
fn constant_effort_accelerates_steadily() {
    let forces = Forces { joint_loads: vec![JointLoad { freedom: 0, effort: 0.3 }], ..Forces::default() };
    let model = one_body(JointKind::Prismatic, 0.2, 0.0, forces);
    let (end, summary) = run(&model, &mut fixed(&model, 2, 0.1), 2.0);
    assert!((end.position[0] - 0.6).abs() < 1e-14 && (end.velocity[0] - 0.6).abs() < 1e-14, "{end:?}");
    assert!(summary.max_relative_energy_error < 1e-14);
    assert!((summary.final_energy.load + 0.3 * end.position[0]).abs() < 1e-15);
}

#[test]
fn damper_between_points_that_turn_together_dissipates_nothing() {
    // Two stages and a fifth of a turn a step: velocities of the embedding would stretch the line by 60 % of its length a
    // second, and the damper would turn the whole energy into heat at once.
    let line = PointSpring {
        name: "rod".to_string(),
        a: models::point_of(Some(0), [0.3, 0.0, 0.0]),
        b: models::point_of(Some(0), [0.0, 0.4, 0.2]),
        stiffness: 0.0,
        damping: 1e4,
        rest_length: 0.0,
    };
    let mut model = one_body(JointKind::Revolute, 0.0, 0.0, Forces { point_springs: vec![line], ..Forces::default() });
    model.state.velocity[0] = 1.2;
    let (end, summary) = run(&model, &mut fixed(&model, 2, 1.0), 20.0);
    assert!(summary.exchange.dissipated < 1e-20, "{:e} J", summary.exchange.dissipated);
    assert!((end.velocity[0] - 1.2).abs() < 1e-13);
}

#[test]
fn torque_about_a_fixed_axis_puts_in_torque_times_angle() {
    let wrench =
        Wrench { body: 0, point: Vector3::zeros(), force: Vector3::zeros(), torque: Vector3::new(0.3, 0.2, 0.1) };
    let model = one_body(JointKind::Revolute, 0.0, 0.0, Forces { wrenches: vec![wrench], ..Forces::default() });
    let (end, summary) = run(&model, &mut fixed(&model, 9, 0.1), 2.0);
    let (work, expected) = (summary.exchange.work, 0.2 * end.position[0]);
    assert!((work - expected).abs() < 1e-11 * expected, "{work} {expected}");
    assert!(summary.max_relative_energy_error < 1e-11);
}

#[test]
fn point_spring_alone_swings_a_free_body_as_the_formula_says() {
    // A point mass on a spring to a fixed point, swinging radially: ℓ = ℓ₀ + A cos ωt.
    let line = PointSpring {
        name: "line".to_string(),
        a: models::point_of(None, [0.0, 0.0, 0.0]),
        b: models::point_of(Some(0), [0.0, 0.0, 0.0]),
        stiffness: 25.0,
        damping: 0.0,
        rest_length: 1.0,
    };
    let joint = Joint::new("free", JointKind::Floating, Pose::identity(), Pose::identity());
    let bodies = vec![models::body("ball", None, 1.0, Vector3::new(0.1, 0.1, 0.1), joint)];
    let mut mechanism = Mechanism::new("ball", Vector3::zeros(), bodies).unwrap();
    mechanism.forces.point_springs = vec![line];
    let mut state = State::zero(&mechanism);
    let direction = Vector3::new(0.6, 0.0, 0.8);
    state.position[..3].copy_from_slice((direction * 1.3).as_slice());
    let model = Model { mechanism, state };
    let (end, _) = run(&model, &mut fixed(&model, 9, 0.05), 2.0);
    let expected = direction * (1.0 + 0.3 * 10.0_f64.cos());
    let error = (Vector3::from_column_slice(&end.position[..3]) - expected).amax();
    assert!(error < 1e-12, "{error:.1e}");
}

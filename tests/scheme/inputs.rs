//! What acts from outside: efforts handed to every step, and forces that change between steps.

use crate::models;
use catena::mechanism::description::forces::{Forces, JointLoad};
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::energy::energy_with_forces;
use catena::mechanism::motion::inputs::Inputs;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::reduced::{Dop853, Euler, Rk4};
use catena::stepping::Lobatto;

/// A trolley of 2 kg on a horizontal rail without friction.
fn trolley() -> models::Model {
    let mut model = models::one_joint(JointKind::Prismatic);
    model.mechanism.bodies.truncate(1);
    model.mechanism.bodies[0].mass = 2.0;
    model.mechanism.gravity = nalgebra::Vector3::zeros();
    let mechanism = Mechanism::new("trolley", model.mechanism.gravity, model.mechanism.bodies).unwrap();
    models::Model { state: State::zero(&mechanism), mechanism }
}

/// Every way of integrating a mechanism, with small fixed steps.
fn integrators(mechanism: &Mechanism, step: f64) -> Vec<(&'static str, Box<dyn Integrator>)> {
    vec![
        ("lobatto", Box::new(Lobatto::fixed(mechanism, 5, step).unwrap())),
        ("lobatto by tolerance", Box::new(Lobatto::adaptive(mechanism, 1e-9))),
        ("dop853", Box::new(Dop853::with_fixed_step(mechanism, step))),
        ("rk4", Box::new(Rk4::new(mechanism, step))),
        ("euler", Box::new(Euler::new(mechanism, step))),
    ]
}

#[test]
fn forces_that_change_between_steps_act_on_the_motion_and_on_the_energy() {
    let models::Model { mut mechanism, state: start } = trolley();
    for (name, mut integrator) in integrators(&mechanism, 0.01) {
        mechanism.forces = Forces::default();
        let mut state = start.clone();
        state.velocity[0] = 0.5;
        // One second freely, one with 6 N, one with −3 N, one freely again.
        for (until, force) in [(1.0, 0.0), (2.0, 6.0), (3.0, -3.0), (4.0, 0.0)] {
            mechanism.forces.joint_loads =
                if force == 0.0 { Vec::new() } else { vec![JointLoad { freedom: 0, effort: force }] };
            let before = energy(&mechanism, &state);
            while state.time < until {
                integrator.advance(&mechanism, &mut state, until).unwrap();
            }
            // A load has a potential, so that nothing is exchanged.
            let gained = energy(&mechanism, &state) - before;
            // Euler is off by some steps; the others are exact but for roundings of two hundred steps.
            let allowed = if name == "euler" { 0.3 } else { 1e-12 };
            assert!(gained.abs() < allowed, "{name}: the energy changes by {gained:e} J until {until} s");
        }
        // v = 0.5, 3.5, 2.0, 2.0 m/s at 1, 2, 3, 4 s; x = 0.5 + 2 + 2.75 + 2 m.
        let allowed = if name == "euler" { 0.05 } else { 1e-12 };
        assert!((state.velocity[0] - 2.0).abs() < 1e-12, "{name}: {} m/s", state.velocity[0]);
        assert!((state.position[0] - 7.25).abs() < allowed, "{name}: {} m", state.position[0]);
    }
}

fn energy(mechanism: &Mechanism, state: &State) -> f64 {
    energy_with_forces(mechanism, &state.position, &body_states(mechanism, state)).total()
}

#[test]
fn efforts_handed_to_every_step_do_what_loads_of_the_mechanism_do_and_their_work_is_counted() {
    let models = [models::double_pendulum(), models::planar_chain(4), models::floating_tree(), models::free_body()];
    for models::Model { mechanism, state: start } in models {
        let efforts: Vec<f64> = (0..mechanism.velocity_count).map(|freedom| 0.07 - 0.031 * freedom as f64).collect();
        let loads = efforts.iter().enumerate().map(|(freedom, &effort)| JointLoad { freedom, effort }).collect();
        let mut loaded = mechanism.clone();
        loaded.forces.joint_loads = loads;
        let references = integrators(&loaded, 0.005);
        for ((name, mut driven), (_, mut reference)) in integrators(&mechanism, 0.005).into_iter().zip(references) {
            if name == "lobatto by tolerance" {
                // Its steps are not the same: work without a potential is judged otherwise than a potential.
                continue;
            }
            let (mut state, mut expected) = (start.clone(), start.clone());
            let (before, mut work) = (energy(&mechanism, &start), 0.0);
            for _ in 0..100 {
                work += driven
                    .step(&mechanism, Inputs::constant(&efforts), &mut state, f64::INFINITY)
                    .unwrap()
                    .exchange
                    .work;
                reference.advance(&loaded, &mut expected, f64::INFINITY).unwrap();
            }
            let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let off = off(&state.position, &expected.position).max(off(&state.velocity, &expected.velocity));
            // The same sums in another order, amplified over half a second.
            assert!(off < 1e-10, "{} by {name}: {off:e}", mechanism.name);
            let gained = energy(&mechanism, &state) - before;
            // What orders 8, 8, 4 and 1 leave at this step.
            let allowed = match name {
                "euler" => 2.0,
                "rk4" => 1e-5,
                _ => 1e-8,
            };
            assert!(
                (gained - work).abs() < allowed,
                "{} by {name}: {gained} J gained, {work} J put in",
                mechanism.name
            );
            assert!(work.abs() > 1e-3, "{}: there is something to be counted", mechanism.name);
        }
    }
}

#[test]
fn efforts_that_change_from_step_to_step_are_those_of_the_step() {
    let models::Model { mechanism, state: start } = trolley();
    for (name, mut integrator) in integrators(&mechanism, 0.05) {
        let mut state = start.clone();
        let mut velocity = 0.0;
        for number in 0..40 {
            let effort = (0.3 * f64::from(number)).sin();
            let until = 0.05 * f64::from(number + 1);
            while state.time < until {
                integrator.step(&mechanism, Inputs::constant(&[effort]), &mut state, until).unwrap();
            }
            velocity += effort / 2.0 * 0.05;
            // Constant accelerations are exact; forty roundings.
            assert!((state.velocity[0] - velocity).abs() < 1e-13, "{name}, step {number}: {} m/s", state.velocity[0]);
        }
        // And then nothing acts.
        let before = state.velocity[0];
        let until = state.time + 0.05;
        integrator.advance(&mechanism, &mut state, until).unwrap();
        assert!((state.velocity[0] - before).abs() < 1e-15, "{name}");
    }
}

#[test]
fn steps_for_trees_under_gravity_alone_refuse_efforts_instead_of_ignoring_them() {
    let models::Model { mechanism, state: start } = models::double_pendulum();
    let refusing = [Lobatto::precise(&mechanism, 5, 0.01), Lobatto::reversible(&mechanism, 5, 0.01)];
    for lobatto in refusing {
        let (mut lobatto, mut state) = (lobatto.unwrap(), start.clone());
        lobatto.advance(&mechanism, &mut state, 1.0).unwrap();
        let error = lobatto.step(&mechanism, Inputs::constant(&[1.0, 0.0]), &mut state, 1.0).unwrap_err();
        assert!(error.to_string().contains("under gravity alone"), "{error}");
    }
}

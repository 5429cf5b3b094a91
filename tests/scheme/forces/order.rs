//! With every force on every kind of joint the order stays, the energy is accounted for, and another method agrees.

use super::{fixed, run};
use crate::models::{self, Model, pose_distance, velocity_distance};
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::motion::kinematics::body_states;
use catena::reduced::{Dop853, Rk4};
use catena::simulation::Summary;
use catena::stepping::integrator::Lobatto;

fn forced_models() -> Vec<Model> {
    let mut all: Vec<Model> = models::JOINT_KINDS.into_iter().map(models::one_joint).collect();
    all.extend([models::double_pendulum(), models::floating_tree()]);
    all
}

#[test]
fn nine_stages_agree_with_dop853_for_every_force_and_every_joint() {
    for model in forced_models() {
        for (kind, forces) in models::every_force(&model.mechanism) {
            let model =
                models::with_forces(Model { mechanism: model.mechanism.clone(), state: model.state.clone() }, forces);
            let mechanism = &model.mechanism;
            let (ours, our_summary) = run(&model, &mut fixed(&model, 9, 0.02), 1.0);
            let (theirs, their_summary) = run(&model, &mut Dop853::new(mechanism, 1e-13), 1.0);
            let (ours, theirs) = (body_states(mechanism, &ours), body_states(mechanism, &theirs));
            let speed =
                theirs.iter().map(|body| body.velocity.amax().max(body.angular_velocity.amax())).fold(1.0, f64::max);
            let (poses, velocities) = (pose_distance(&ours, &theirs), velocity_distance(&ours, &theirs) / speed);
            let exchanged = [our_summary.exchange, their_summary.exchange];
            let scale = our_summary.initial_energy.kinetic.max(1.0);
            let heat = (exchanged[0].dissipated - exchanged[1].dissipated).abs() / scale;
            let work = (exchanged[0].work - exchanged[1].work).abs() / scale;
            let name = &mechanism.name;
            println!(
                "{name}, {kind}: {poses:.1e} {velocities:.1e}, heat {heat:.1e} work {work:.1e}, balance {:.1e} {:.1e}, halved {}",
                our_summary.max_relative_energy_error,
                their_summary.max_relative_energy_error,
                our_summary.cost.rejected.total()
            );
            // As without forces: a hundred and more roundings of each, and the tolerance of DOP853.
            assert!(poses < 1e-11 && velocities < 1e-11, "{name}, {kind}: {poses:.1e}, {velocities:.1e}");
            assert!(heat < 1e-11 && work < 1e-11, "{name}, {kind}: heat {heat:.1e}, work {work:.1e}");
            let balance = our_summary.max_relative_energy_error.max(their_summary.max_relative_energy_error);
            assert!(balance < 1e-11, "{name}, {kind}: {balance:.1e} of the energy is not accounted for");
        }
    }
}

fn after(model: &Model, stages: usize, step: f64, time: f64) -> (Vec<BodyState>, Summary) {
    let (state, summary) = run(model, &mut fixed(model, stages, step), time);
    assert_eq!(summary.cost.rejected.total(), 0, "s={stages} h={step}: a step was halved, the order would not be seen");
    (body_states(&model.mechanism, &state), summary)
}

/// Observed orders of the poses and of the energy balance with all forces.
fn check_orders(model: Model, time: f64, cases: &[(usize, f64)]) {
    let forces = models::every_force(&model.mechanism).pop().unwrap().1;
    let model = models::with_forces(model, forces);
    let (reference, exact) = after(&model, 9, time / 80.0, time);
    for &(stages, step) in cases {
        let measure = |step: f64| {
            let (bodies, summary) = after(&model, stages, step, time);
            (pose_distance(&bodies, &reference), (summary.exchange.dissipated - exact.exchange.dissipated).abs())
        };
        let (coarse, fine) = (measure(step), measure(0.5 * step));
        let orders = [(coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2()];
        println!("{} s={stages}: orders {orders:.2?}, errors {coarse:?} {fine:?}", model.mechanism.name);
        let expected = (2 * stages - 2) as f64;
        // As in tests/scheme/order.rs. What is dissipated may happen to have a small leading error and look better than it is.
        assert!((orders[0] - expected).abs() < 0.5, "s={stages}: order {:.2}, expected {expected}", orders[0]);
        assert!(orders[1] > expected - 0.5, "s={stages}: order of the heat {:.2}, expected {expected}", orders[1]);
        assert!(fine.0 > 1e-13, "s={stages}: the finer error {:.1e} is rounding and shows no order", fine.0);
    }
}

#[test]
fn order_is_two_s_minus_two_with_all_forces_on_a_double_pendulum() {
    check_orders(models::double_pendulum(), 1.0, &[(2, 0.0125), (3, 0.025), (4, 0.05), (5, 0.1)]);
}

#[test]
fn order_is_two_s_minus_two_with_all_forces_on_ball_joints() {
    check_orders(models::one_joint(JointKind::Spherical), 1.0, &[(2, 0.0125), (3, 0.025), (4, 0.025)]);
}

#[test]
fn order_is_two_s_minus_two_with_all_forces_on_a_floating_tree() {
    check_orders(models::floating_tree(), 1.0, &[(2, 0.005), (3, 0.025), (4, 0.05)]);
}

#[test]
fn energy_balance_closes_with_chosen_steps_too() {
    for model in forced_models() {
        let forces = models::every_force(&model.mechanism).pop().unwrap().1;
        let model = models::with_forces(model, forces);
        let (_, summary) = run(&model, &mut Lobatto::adaptive(&model.mechanism, 1e-8), 2.0);
        let balance = summary.max_relative_energy_error;
        println!("{}: {balance:.1e} with {} steps", model.mechanism.name, summary.steps);
        // What the controller allows a step, times the steps: a share of 0.03 of the tolerance each.
        assert!(balance < 1e-8 && summary.exchange.dissipated > 0.1, "{}: {summary:?}", model.mechanism.name);
    }
}

#[test]
fn fourth_order_comparator_accounts_for_the_energy_at_its_own_order() {
    let model =
        models::with_forces(models::double_pendulum(), models::joint_dampers(&models::double_pendulum().mechanism));
    let balance = |step: f64| run(&model, &mut Rk4::new(&model.mechanism, step), 1.0).1.max_relative_energy_error;
    let order = (balance(0.02) / balance(0.01)).log2();
    assert!(order > 3.5, "{order:.2}");
}

#[test]
fn damper_of_no_strength_changes_nothing_but_rounding() {
    for model in forced_models() {
        let mut idle = models::joint_dampers(&model.mechanism);
        idle.joint_dampers.iter_mut().for_each(|damper| damper.coefficient = 0.0);
        let idle = models::with_forces(Model { mechanism: model.mechanism.clone(), state: model.state.clone() }, idle);
        let (without, with) = (after(&model, 5, 0.01, 0.5).0, after(&idle, 5, 0.01, 0.5).0);
        let difference = pose_distance(&without, &with);
        assert!(difference < 1e-12, "{}: {difference:.1e}", model.mechanism.name);
    }
}

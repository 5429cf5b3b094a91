//! Forces besides gravity: the order stays, the energy is accounted for, and analytic, published and independent answers
//! are met.

#![allow(clippy::excessive_precision, reason = "reference values stand as their source prints them")]

use crate::common::run_until;
use crate::models;
use crate::models::{Model, pose_distance, velocity_distance};
use catena::forces::{Forces, JointDamper, JointLoad, JointSpring, PointSpring, Wrench};
use catena::kinematics::body_states;
use catena::lobatto::Lobatto;
use catena::lobatto::tableau::Tableau;
use catena::model::{Coordinate, Joint, JointKind, Mechanism, Pose};
use catena::reduced::{Dop853, Rk4};
use catena::simulation::{Integrator, Summary};
use catena::state::{BodyState, State};
use nalgebra::{DMatrix, DVector, Vector3};

/// A box on one joint whose axis is y and whose centre of mass is `below` under the joint.
fn one_body(kind: JointKind, below: f64, gravity: f64, forces: Forces) -> Model {
    let axis = if kind == JointKind::Spherical { Vector3::z() } else { Vector3::y() };
    let on_child = models::frame(Vector3::new(0.0, 0.0, below), axis);
    let joint = Joint::new("joint", kind, models::frame(Vector3::zeros(), axis), on_child);
    let inertia = models::box_inertia(1.0, Vector3::new(0.1, 0.1, 1.0));
    let bodies = vec![models::body("box", None, 1.0, inertia, joint)];
    let mut mechanism = Mechanism::new("one_body", Vector3::new(0.0, 0.0, -gravity), bodies).unwrap();
    mechanism.forces = forces;
    let state = State::zero(&mechanism);
    Model { mechanism, state }
}

fn damper(coefficient: f64) -> Vec<JointDamper> {
    vec![JointDamper { freedom: 0, coefficient }]
}

fn spring(stiffness: f64, rest: f64) -> Vec<JointSpring> {
    vec![JointSpring { coordinate: Coordinate { body: 0, position: 0, freedom: 0 }, stiffness, rest }]
}

fn run(model: &Model, integrator: &mut dyn Integrator, until: f64) -> (State, Summary) {
    let mut state = model.state.clone();
    let summary = run_until(&model.mechanism, &mut state, integrator, until);
    (state, summary)
}

fn fixed(model: &Model, stages: usize, step: f64) -> Lobatto {
    Lobatto::fixed(&model.mechanism, stages, step).unwrap()
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
                our_summary.rejected_steps
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
    assert_eq!(summary.rejected_steps, 0, "s={stages} h={step}: a step was halved, the order would not be seen");
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
fn any_damper_alone_is_stable_for_any_step() {
    // y'' = −c y' with z = h c: v̄ = v₀ − z Σ b_k V_k, V = v₀ − z Ā V. The amplification is the diagonal Padé approximant of
    // exp(−z), which never exceeds one.
    for stages in 2..=16 {
        let tableau = Tableau::of(stages).unwrap();
        let a_bar = DMatrix::from_row_slice(stages, stages, &tableau.a_bar);
        let ones = DVector::from_element(stages, 1.0);
        for exponent in -20..=60 {
            let z = 10_f64.powf(0.1 * f64::from(exponent));
            let rates = (DMatrix::identity(stages, stages) + &a_bar * z).lu().solve(&ones).unwrap();
            let growth = 1.0 - z * rates.dot(&DVector::from_vec(tableau.weights.clone()));
            assert!(growth.abs() < 1.0, "s={stages}, h c = {z:.1e}: {growth}");
        }
    }
}

/// Growth of the solutions of `y'' = −ω² y − 2ζω y'` in one step with h = 1: spectral radius of the step.
fn growth(tableau: &Tableau, omega: f64, damping_ratio: f64) -> f64 {
    let s = tableau.stages;
    let (stiffness, damping) = (omega * omega, 2.0 * damping_ratio * omega);
    let a = DMatrix::from_row_slice(s, s, &tableau.a);
    let a_bar = DMatrix::from_row_slice(s, s, &tableau.a_bar);
    let weights = DVector::from_vec(tableau.weights.clone());
    let ones = DVector::from_element(s, 1.0);
    // F = −k Y − c V,  V = v₀ + Ā F,  Y = y₀ + A V.
    let system = (DMatrix::identity(s, s) + &a * &a_bar * stiffness + &a_bar * damping).lu();
    let by_position = system.solve(&(&ones * -stiffness)).unwrap();
    let by_velocity = system.solve(&(&a * &ones * -stiffness - &ones * damping)).unwrap();
    let step = nalgebra::Matrix2::new(
        1.0 + weights.dot(&(&a_bar * &by_position)),
        1.0 + weights.dot(&(&a_bar * &by_velocity)),
        weights.dot(&by_position),
        1.0 + weights.dot(&by_velocity),
    );
    step.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}

#[test]
fn spring_under_a_hard_damper_limits_the_step_at_the_documented_place() {
    // benches/README.md: h ω = (s − 1) √(2s) for any hard damper; a per mille to either side.
    for stages in 2..=9 {
        let tableau = Tableau::of(stages).unwrap();
        let limit = (stages as f64 - 1.0) * (2.0 * stages as f64).sqrt();
        assert!(growth(tableau, 0.999 * limit, 1e3) < 1.0, "s={stages}");
        assert!(growth(tableau, 1.001 * limit, 1e3) > 1.0, "s={stages}");
    }
}

#[test]
fn slow_motion_under_a_stiff_damper_keeps_its_accuracy_at_thousands_of_its_time_constants() {
    // A pendulum in honey: c θ' = −m g l sin θ but for the inertia, tan(θ/2) = tan(θ₀/2) exp(−t m g l / c). The damper's time
    // constant I/c is 3e-5 s; the steps are 3000 times longer.
    let coefficient = 1e4;
    let mut model =
        one_body(JointKind::Revolute, 0.5, 9.81, Forces { joint_dampers: damper(coefficient), ..Forces::default() });
    let fall = 9.81 * 0.5 / coefficient;
    model.state.position[0] = 2.0;
    model.state.velocity[0] = -fall * 2.0_f64.sin();
    for stages in [2, 3, 5, 9] {
        let (end, summary) = run(&model, &mut fixed(&model, stages, 0.1), 100.0);
        let expected = 2.0 * (1.0_f64.tan() * (-100.0 * fall).exp()).atan();
        let error = (end.position[0] - expected).abs();
        println!("s={stages}: {error:.1e}, {} iterations, halved {}", summary.iterations, summary.rejected_steps);
        // The inertia left out of the formula changes the motion by (m g l / c)² I / (m g l) of itself: below 1e-8.
        assert!(error < 1e-7, "s={stages}: {error:.1e}");
        // No step is halved: with nine stages the simplified iteration gives up now and then before the exact one is asked.
        assert_eq!(summary.steps, 1000, "s={stages}");
    }
}

#[test]
fn a_motion_that_hard_dampers_stop_is_stopped_with_a_tolerance_and_said_to_ring_in_long_fixed_steps() {
    // A finger of 1e-6 kg m² behind a damper of 1 N m s: it stops within a microsecond, after v/γ.
    for (rate, hardness) in [(2.0, 1.0), (-1.0, 1e3), (3.0, 0.01)] {
        let mut model =
            one_body(JointKind::Revolute, 0.0, 0.0, Forces { joint_dampers: damper(hardness), ..Forces::default() });
        model.mechanism.bodies[0].inertia = Vector3::repeat(1e-6);
        model.state.position[0] = 0.0;
        model.state.velocity[0] = rate;
        let decay = hardness / 1e-6;
        let mut chosen = Lobatto::adaptive(&model.mechanism, 1e-6);
        let (end, summary) = run(&model, &mut chosen, 1.0);
        // Short steps are iterated as far as others, to 1e-10 rad, which is more of a velocity; what is left of it rings in long ones.
        assert!(end.velocity[0].abs() < 1e-6, "{hardness}: {} rad/s left", end.velocity[0]);
        // What the first step, too long, has left of the way.
        assert!((end.position[0] - rate / decay).abs() < 1e-6, "{hardness}: at {:e}", end.position[0]);
        assert!(summary.steps < 80, "{hardness}: {} steps", summary.steps);
        assert_eq!(chosen.description().ringing, None);

        let mut long = fixed(&model, 9, 0.1);
        let (rings, _) = run(&model, &mut long, 0.1);
        let seen = long.description().ringing.unwrap();
        assert!((seen.decay / decay - 1.0).abs() < 1e-6, "{hardness}: {seen:?}");
        assert!(rings.velocity[0].abs() > 0.5 * rate.abs(), "{hardness}: {} rad/s", rings.velocity[0]);
        let mut short = fixed(&model, 9, seen.longest);
        let (stopped, _) = run(&model, &mut short, 8.0 * seen.longest);
        // Nothing but what the iteration leaves, 1e-12 rad or less, times 36 over the step.
        assert!(stopped.velocity[0].abs() < 36e-12 / seen.longest, "{hardness}: {} rad/s", stopped.velocity[0]);
        assert_eq!(short.description().ringing, None);
    }
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

//! Controllers that act at every instant.

use crate::mechanisms::*;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::StopRule;
use catena::mechanism::description::forces::{JointDamper, JointSpring};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::model::{Model, ModelOptions};
use catena::scene::{PackagePath, read_urdf};
use catena::simulation::{ContinuousController, ControlError, Finished, Simulation, SimulationOptions, StepChoice};
use catena::stepping::integrator::Lobatto;
use nalgebra::{DMatrix, Vector3};
use std::path::Path;

pub fn run_under(
    mechanism: &Mechanism,
    start: &State,
    duration: f64,
    steps: StepChoice,
    controller: &dyn ContinuousController,
) -> Result<Finished, ControlError> {
    let options = SimulationOptions::new(duration, steps);
    let mut simulation = Simulation::new(mechanism, start.clone(), options).unwrap();
    simulation.run_under_continuous(controller)?;
    Ok(simulation.finish())
}

/// `kp (r − q) + kd (0 − q̇)` in all joints; `told` of its derivatives are given.
pub struct Hold {
    pub kp: f64,
    pub kd: f64,
    pub target: f64,
    pub told: f64,
}

impl ContinuousController for Hold {
    fn freedoms(&self, mechanism: &Mechanism) -> Vec<usize> {
        (0..mechanism.velocity_count).collect()
    }

    fn efforts(&self, _: &Mechanism, state: &State, efforts: &mut [f64]) {
        for (index, effort) in efforts.iter_mut().enumerate() {
            let position = state.position[index] + state.compensation[index];
            *effort = self.kp * (self.target - position) - self.kd * state.velocity[index];
        }
    }

    fn derivatives(&self, _: &Mechanism, _: &State, positions: &mut DMatrix<f64>, velocities: &mut DMatrix<f64>) {
        positions.fill_diagonal(-self.told * self.kp);
        velocities.fill_diagonal(-self.told * self.kd);
    }
}

fn arm() -> Mechanism {
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/arm7.urdf");
    let urdf = read_urdf(&robot, &PackagePath::default()).unwrap();
    let mut mechanism = Model::new(urdf, &ModelOptions::default()).unwrap().mechanism;
    mechanism.nonsmooth = Default::default();
    mechanism
}

/// The largest distance of two joint positions (rad).
fn apart(one: &State, other: &State) -> f64 {
    one.position.iter().zip(&other.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_continuous_law_of_position_and_rate_is_the_built_in_motor_to_rounding() {
    let arm = arm();
    let start = State::zero(&arm);
    // Where gains are stiff the wrist's decay is far beyond the steps.
    for (kp, kd, told, step) in [(1000.0, 50.0, 1.0, 0.005), (20.0, 1.0, 0.9, 0.001)] {
        let law = Hold { kp, kd, target: 0.3, told };
        let ours = run_under(&arm, &start, 0.5, fixed(5, step), &law).unwrap();
        let mut with_motors = arm.clone();
        for body in 0..with_motors.bodies.len() {
            motor(&mut with_motors, body, MotorLaw::Position { kp, kd }, Target::constant(0.3), f64::INFINITY, 0.0);
        }
        let built_in = run(&with_motors, &start, 0.5, fixed(5, step));
        // Hundreds of steps solved to rounding, of positions below 1 rad.
        let found = apart(&ours.state, &built_in.state);
        assert!(found < 1e-13, "kp {kp}, kd {kd}: {found:e}");
        assert_eq!(ours.summary.cost.rejected.total(), 0);
    }
}

#[test]
fn a_continuous_law_is_solved_to_rounding_whatever_derivatives_are_told() {
    let arm = arm();
    let start = State::zero(&arm);
    let (kp, kd) = (100.0, 10.0);
    let [exact, coarse] = [1.0, 0.9].map(|told| {
        let law = Hold { kp, kd, target: 0.3, told };
        run_under(&arm, &start, 0.5, fixed(5, 0.005), &law).unwrap()
    });
    // As above; and coarse derivatives cost iterations.
    assert!(apart(&exact.state, &coarse.state) < 1e-13, "{:e}", apart(&exact.state, &coarse.state));
    assert!(exact.summary.cost.iterations < coarse.summary.cost.iterations);
    // The same as springs and dampers, iterated until nothing falls any more: the usual rule takes increments of 1e-11 for rounding.
    let mut passive = arm.clone();
    for body in 0..passive.bodies.len() {
        let coordinate = coordinate(&passive, body);
        passive.forces.joint_springs.push(JointSpring { coordinate, stiffness: kp, rest: 0.3 });
        passive.forces.joint_dampers.push(JointDamper { freedom: coordinate.freedom, coefficient: kd });
    }
    let rule = StopRule { rounding: 1e-15, ..StopRule::ROUNDING };
    let mut lobatto = Lobatto::fixed_with(&passive, 5, 0.005, rule, Isa::detect()).unwrap();
    let mut state = start.clone();
    while state.time < 0.5 {
        lobatto.advance(&passive, &mut state, 0.5).unwrap();
    }
    assert!(apart(&exact.state, &state) < 1e-13, "{:e}", apart(&exact.state, &state));
}

/// m g l (J), J about the hinge (kg m²) and m l (kg m) of the pole; mass of both (kg).
const POLE: [f64; 4] = [0.2 * GRAVITY * 0.5, 0.2 * 0.25 + 0.016, 0.2 * 0.5, 1.2];

/// `u = −k (E − m g l) θ̇ cos θ − kx x − kv ẋ`.
struct SwingUp;

fn swing_up(position: &[f64], velocity: &[f64]) -> f64 {
    let missing = 0.5 * POLE[1] * velocity[1].powi(2) - POLE[0] * (position[1].cos() + 1.0);
    -4.0 * missing * velocity[1] * position[1].cos() - position[0] - velocity[0]
}

impl ContinuousController for SwingUp {
    fn freedoms(&self, _: &Mechanism) -> Vec<usize> {
        vec![0]
    }

    fn efforts(&self, _: &Mechanism, state: &State, efforts: &mut [f64]) {
        efforts[0] = swing_up(&state.position, &state.velocity);
    }

    fn derivatives(&self, _: &Mechanism, state: &State, positions: &mut DMatrix<f64>, velocities: &mut DMatrix<f64>) {
        // Differences are good enough for derivatives.
        let moved = |values: &[f64], index: usize| {
            let mut moved = values.to_vec();
            moved[index] += 1e-6;
            moved
        };
        let (position, velocity) = (&state.position, &state.velocity);
        for index in 0..2 {
            let here = swing_up(position, velocity);
            positions[(0, index)] = (swing_up(&moved(position, index), velocity) - here) / 1e-6;
            velocities[(0, index)] = (swing_up(position, &moved(velocity, index)) - here) / 1e-6;
        }
    }
}

/// The same by the classical Runge–Kutta method of the equations written out, an oracle that shares no line:
/// `(M + m) ẍ − m l (θ̈ cos θ − θ̇² sin θ) = u`, `J θ̈ − m l ẍ cos θ + m g l sin θ = 0`.
fn literal_swing_up(angle: f64, duration: f64, steps: usize) -> [f64; 4] {
    let slope = |y: [f64; 4]| {
        let [x, theta, v, w] = y;
        let (sin, cos) = theta.sin_cos();
        let u = swing_up(&[x, theta], &[v, w]);
        let [weight, inertia, moment, mass] = POLE;
        let (a, b) = (u - moment * w * w * sin, -weight * sin);
        let determinant = mass * inertia - (moment * cos).powi(2);
        [v, w, (a * inertia + moment * cos * b) / determinant, (mass * b + moment * cos * a) / determinant]
    };
    let add = |y: [f64; 4], h: f64, k: [f64; 4]| std::array::from_fn(|i| y[i] + h * k[i]);
    let (mut y, h) = ([0.0, angle, 0.0, 0.0], duration / steps as f64);
    for _ in 0..steps {
        let k1 = slope(y);
        let k2 = slope(add(y, 0.5 * h, k1));
        let k3 = slope(add(y, 0.5 * h, k2));
        let k4 = slope(add(y, h, k3));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
    }
    y
}

#[test]
fn order_is_kept_under_a_nonlinear_law_that_acts_at_every_instant() {
    let cart = slide("rail", Vector3::x(), 1.0);
    let pole = hinge("hinge", Some(0), Vector3::zeros(), 0.5, 0.2, 0.016);
    let mechanism = mechanism(vec![cart, pole]);
    let start = at_rest(&mechanism, &[0.0, 0.4]);
    let duration = 2.0;
    let wanted = literal_swing_up(0.4, duration, 40_000);
    let error = |stages: usize, step: f64| {
        let done = run_under(&mechanism, &start, duration, fixed(stages, step), &SwingUp).unwrap();
        let found = [done.state.position[0], done.state.position[1], done.state.velocity[0], done.state.velocity[1]];
        found.iter().zip(wanted).map(|(found, wanted)| (found - wanted).abs()).fold(0.0, f64::max)
    };
    for (stages, steps) in [(2, [0.02, 0.01, 0.005]), (3, [0.04, 0.02, 0.01]), (5, [0.1, 0.05, 0.025])] {
        let errors = steps.map(|step| error(stages, step));
        let slopes: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
        println!("{stages} stages: {errors:?} {slopes:?}");
        assert!((slopes[1] - (2 * stages - 2) as f64).abs() < 0.5, "{stages} stages: {errors:?}, {slopes:?}");
    }
    // The oracle has order 4 at steps of 5e-5: some 1e-13.
    let nine = error(9, 0.05);
    println!("9 stages: {nine:e}");
    assert!(nine < 2e-12, "{nine:e}");
    let done = run_under(&mechanism, &start, duration, StepChoice::Tolerance(1e-9), &SwingUp).unwrap();
    assert!((done.state.position[1] - wanted[1]).abs() < 1e-7 && done.summary.max_relative_energy_error < 1e-8);
}

#[test]
fn a_continuous_law_that_cannot_act_is_refused() {
    let mut one = pendulum();
    struct Everywhere(Vec<usize>);
    impl ContinuousController for Everywhere {
        fn freedoms(&self, _: &Mechanism) -> Vec<usize> {
            self.0.clone()
        }
        fn efforts(&self, _: &Mechanism, _: &State, efforts: &mut [f64]) {
            efforts.fill(f64::NAN);
        }
        fn derivatives(&self, _: &Mechanism, _: &State, _: &mut DMatrix<f64>, _: &mut DMatrix<f64>) {}
    }
    let start = at_rest(&one, &[0.3]);
    let refused = |mechanism: &Mechanism, freedoms: &[usize]| {
        run_under(mechanism, &start, 1.0, fixed(3, 0.1), &Everywhere(freedoms.to_vec())).unwrap_err()
    };
    assert!(matches!(refused(&one, &[1]), ControlError::Freedom { freedom: 1, count: 1 }));
    assert!(matches!(refused(&one, &[0, 0]), ControlError::Freedom { .. }));
    let names = "at t = 0 s the controller's effort along joint \"hinge\" is NaN: make it finite in every state";
    assert_eq!(refused(&one, &[0]).to_string(), names);
    friction(&mut one, 0, 100.0);
    assert_eq!(refused(&one, &[0]).to_string(), names, "where friction would hold it, too");
}

//! The fastest frequency of a tree under gravity, and the accelerations and rates that it is found from.

use super::start_of;
use crate::common::shared;
use crate::models::{self, Model};
use catena::lobatto::plan::tree::Plan;
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::energy::energy;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::model::ModelOptions;
use catena::reduced::ReducedOde;
use catena::scene::{PackagePath, read_urdf};
use catena::stepping::integrator::Lobatto;
use catena::stepping::watching::dynamics::Dynamics;
use catena::stepping::watching::fastest_mode::Fastest;
use nalgebra::{DMatrix, Matrix3, SymmetricEigen, Vector3};

/// Second derivatives of a centre of mass and of a rotation matrix.
type Acceleration = (Vector3<f64>, Matrix3<f64>);

/// Every joint with a velocity.
fn moving(mut model: Model) -> Model {
    for (index, rate) in model.state.velocity.iter_mut().enumerate() {
        *rate = 1.5 - 0.8 * index as f64;
    }
    model
}

/// The state after a time `t` on the parabola with the velocities and accelerations of `state`; hinges only.
fn along(state: &State, accelerations: &[f64], t: f64) -> State {
    let mut moved = state.clone();
    for ((position, rate), acceleration) in moved.position.iter_mut().zip(&state.velocity).zip(accelerations) {
        *position += t * rate + 0.5 * t * t * acceleration;
    }
    moved
}

/// The largest |ω| from dense matrices, and the largest of those that oscillate: `H` from kinetic energies, `K` as the Hessian of
/// `Σ m (ẍ − g)·x(q) + tr(R̈ Σ R(q)ᵀ)` with the accelerations held, both by differences.
fn dense_frequencies(mechanism: &Mechanism, state: &State) -> (f64, f64) {
    let n = mechanism.velocity_count;
    let mut accelerations = vec![0.0; n];
    ReducedOde::new(mechanism).accelerations(&state.position, &state.velocity, &mut accelerations);
    let poses = |t: f64| body_states(mechanism, &along(state, &accelerations, t));
    let t = 1e-3 / (1.0 + state.velocity.iter().fold(0.0, |most: f64, rate| most.max(rate.abs())));
    let at = [poses(-2.0 * t), poses(-t), poses(0.0), poses(t), poses(2.0 * t)];
    let weights = [-1.0, 16.0, -30.0, 16.0, -1.0].map(|weight| weight / (12.0 * t * t));
    let second = |body: usize| -> Acceleration {
        let zero = (Vector3::zeros(), Matrix3::zeros());
        at.iter().zip(weights).fold(zero, |sum, (poses, weight)| {
            (sum.0 + weight * poses[body].position, sum.1 + weight * poses[body].rotation)
        })
    };
    let held: Vec<_> = (0..mechanism.bodies.len()).map(second).collect();
    let action = |poses: &[BodyState]| -> f64 {
        let term =
            |(body, (pose, held)): (&catena::mechanism::description::mechanism::Body, (&BodyState, &Acceleration))| {
                let sigma = Vector3::repeat(0.5 * body.inertia.sum()) - body.inertia;
                body.mass * (held.0 - mechanism.gravity).dot(&pose.position)
                    + (held.1 * Matrix3::from_diagonal(&sigma) * pose.rotation.transpose()).trace()
            };
        mechanism.bodies.iter().zip(poses.iter().zip(&held)).map(term).sum()
    };
    let step = 1e-3;
    let moved = |i: usize, a: f64, j: usize, b: f64| {
        let mut moved = state.clone();
        moved.position[i] += a * step;
        moved.position[j] += b * step;
        action(&body_states(mechanism, &moved))
    };
    let stiffness = DMatrix::from_fn(n, n, |i, j| {
        (moved(i, 1.0, j, 1.0) - moved(i, 1.0, j, -1.0) - moved(i, -1.0, j, 1.0) + moved(i, -1.0, j, -1.0))
            / (4.0 * step * step)
    });
    let kinetic = |i: usize, j: usize| {
        let mut moving = state.clone();
        moving.velocity.fill(0.0);
        moving.velocity[i] += 1.0;
        moving.velocity[j] += 1.0;
        energy(mechanism, &body_states(mechanism, &moving)).kinetic
    };
    let inertia = DMatrix::from_fn(n, n, |i, j| kinetic(i, j) - 0.25 * (kinetic(i, i) + kinetic(j, j)));
    let root = inertia.cholesky().unwrap().l();
    let inner = root.solve_lower_triangular(&stiffness).unwrap();
    let reduced = root.solve_lower_triangular(&inner.transpose()).unwrap();
    let values = SymmetricEigen::new(0.5 * (&reduced + reduced.transpose())).eigenvalues;
    let largest = |size: fn(f64) -> f64| values.iter().fold(0.0, |most: f64, &value| most.max(size(value))).sqrt();
    (largest(f64::abs), largest(|value| value))
}

#[test]
fn the_fastest_frequency_is_that_of_dense_matrices() {
    let chain = models::chain(6);
    for model in [models::double_pendulum(), chain].map(moving) {
        let mechanism = &model.mechanism;
        let state = model.state;
        let (plan, start) = start_of(mechanism, &state);
        let mut dynamics = Dynamics::new(&plan, mechanism.velocity_count);
        let mut fastest = Fastest::new(mechanism.velocity_count);
        let found = fastest.estimate(&mut dynamics, &plan, &start, &mechanism.gravity.into(), 200);
        let (expected, _) = dense_frequencies(mechanism, &state);
        // Differences with steps of 1e-3: six digits of K, three of them used up by its ill-conditioned congruence.
        assert!((found - expected).abs() < 1e-3 * expected, "{}: {found}, dense {expected}", mechanism.name);
    }
}

/// The largest difference relative to the largest number.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / size
}

#[test]
fn accelerations_and_their_rates_are_those_of_the_comparator() {
    let models = [models::double_pendulum(), models::chain(6), models::floating_tree(), models::spatial_pendulum()];
    for model in models.map(moving) {
        let mechanism = &model.mechanism;
        let state = &model.state;
        let count = mechanism.velocity_count;
        let (plan, start) = start_of(mechanism, state);
        let mut dynamics = Dynamics::new(&plan, count);
        dynamics.set(&plan, &start, &mechanism.gravity.into());
        let mut ode = ReducedOde::new(mechanism);
        let mut at = |state: &State| {
            let mut out = vec![0.0; count];
            ode.accelerations(&state.position, &state.velocity, &mut out);
            out
        };
        let expected = at(state);
        // The same recursion in other coordinates: roundings, times the condition of the light links.
        let error = apart(dynamics.accelerations(), &expected);
        assert!(error < 1e-10, "{}: {error:.1e}", mechanism.name);

        let step = 1e-4;
        let shifted = |sign: f64| {
            let mut moved = state.clone();
            let displacement: Vec<f64> = state
                .velocity
                .iter()
                .zip(&expected)
                .map(|(rate, acceleration)| sign * step * rate + 0.5 * step * step * acceleration)
                .collect();
            moved.displace(mechanism, &displacement);
            moved
                .velocity
                .iter_mut()
                .zip(&expected)
                .for_each(|(rate, acceleration)| *rate += sign * step * acceleration);
            moved
        };
        let (after, before) = (at(&shifted(1.0)), at(&shifted(-1.0)));
        let slope: Vec<f64> = after.iter().zip(&before).map(|(a, b)| (a - b) / (2.0 * step)).collect();
        let mut jerks = vec![0.0; count];
        dynamics.jerks(&plan, &start, &mut jerks);
        // A central difference of step 1e-4 is good to 1e-8 times the square of the rates, here up to some tens per second.
        let error = apart(&jerks, &slope);
        assert!(error < 1e-4, "{}: {error:.1e}", mechanism.name);
    }
}

#[test]
fn the_fastest_frequency_of_a_chain_with_a_heavy_tip_grows_as_it_falls_taut() {
    let Some(folder) = shared("reference/scenes") else { return };
    let answer = std::fs::read_to_string(folder.join("../answers/heavy_tip_T05.json")).unwrap();
    let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
    let gravity = Vector3::from_fn(|axis, _| answer["gravity"][axis].as_f64().unwrap());
    let robot = read_urdf(&folder.join("heavy_tip_T05.urdf"), &PackagePath::default()).unwrap();
    let model = catena::model::Model::new(robot, &ModelOptions { gravity, ..Default::default() }).unwrap();
    let mechanism = &model.mechanism;
    let of = |key: &str| -> Vec<(String, Vec<f64>)> {
        let joints = answer["initial"].as_object().unwrap();
        joints.iter().map(|(joint, value)| (joint.clone(), vec![value[key].as_f64().unwrap()])).collect()
    };
    let mut state = model.initial_state(&of("position"), &of("velocity"), None).unwrap();
    let mut lobatto = Lobatto::fixed(mechanism, 9, 1e-3).unwrap();
    let plan = Plan::new(mechanism);
    let mut dynamics = Dynamics::new(&plan, mechanism.velocity_count);
    let mut fastest = Fastest::new(mechanism.velocity_count);
    let mut largest = 0.0_f64;
    for hundredths in 0..=50 {
        let time = 0.01 * f64::from(hundredths);
        while state.time < time {
            lobatto.advance(mechanism, &mut state, time).unwrap();
        }
        let (_, start) = start_of(mechanism, &state);
        let found = fastest.estimate(&mut dynamics, &plan, &start, &mechanism.gravity.into(), 30);
        largest = largest.max(found);
        // Thirty iterations from the mode of 0.01 s before; where two modes are equally fast they find something between.
        let (dense, oscillating) = dense_frequencies(mechanism, &state);
        assert!(found < 1.001 * dense && found > 0.98 * dense, "t = {time}: {found}, dense {dense}");
        assert!((dense - oscillating).abs() < 1e-3 * dense, "t = {time}: the fastest mode does not oscillate");
        if hundredths == 5 {
            assert!((found - 250.0).abs() < 5.0, "{found}");
        }
    }
    // Two numbers that another program found by power iteration on its own matrices: 250 at 0.05 s and 1180 towards the end.
    assert!((largest - 1180.0).abs() < 20.0, "{largest}");
}

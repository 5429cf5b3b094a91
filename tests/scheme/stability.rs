//! Where the scheme becomes unstable, and that it is known how near a step is to it.

use crate::common::shared;
use crate::models::Model;
use crate::{closed, models};
use catena::forces::{JointDamper, JointSpring, PointSpring};
use catena::invariants::energy;
use catena::kinematics::body_states;
use catena::lobatto::Lobatto;
use catena::lobatto::dynamics::Dynamics;
use catena::lobatto::fastest::Fastest;
use catena::lobatto::linearised::Linearised;
use catena::lobatto::stability::{damped_limit, limit};
use catena::lobatto::start::{Plan, Start};
use catena::lobatto::tableau::Tableau;
use catena::model::Mechanism;
use catena::model::{Coordinate, Joint, JointKind, ModelOptions, Pose};
use catena::reduced::ReducedOde;
use catena::scene::{PackagePath, read_urdf};
use catena::simulation::{Integrator, StepError};
use catena::state::{BodyState, State};
use nalgebra::{DMatrix, Matrix3, SymmetricEigen, Vector3};

/// Second derivatives of a centre of mass and of a rotation matrix.
type Acceleration = (Vector3<f64>, Matrix3<f64>);

#[test]
fn the_stability_limits_are_those_of_the_pair() {
    // Known in closed form: 2 for Störmer and Verlet, √8 for three stages; the others by independent computation
    // (a scan of the 2 x 2 propagation with the tableau from another program), to the digits given.
    let known = [(2, 2.0), (3, 8f64.sqrt()), (4, 5.477), (5, 6.054), (6, 8.841), (7, 9.267), (8, 12.15), (9, 12.46)];
    for (stages, expected) in known {
        let found = limit(Tableau::of(stages).unwrap());
        assert!((found - expected).abs() < 1e-3 * expected, "{stages} stages: {found}, expected {expected}");
    }
}

/// Every joint with a velocity.
fn moving(mut model: Model) -> Model {
    for (index, rate) in model.state.velocity.iter_mut().enumerate() {
        *rate = 1.5 - 0.8 * index as f64;
    }
    model
}

fn start_of(mechanism: &Mechanism, state: &State) -> (Plan, Start) {
    let mut start = Start::new(mechanism);
    start.set(mechanism, state);
    (Plan::new(mechanism), start)
}

/// Three light links with a heavy tip, turning at 20 rad/s, the joints slightly bent.
fn taut_chain() -> Model {
    let mut bodies = Vec::new();
    for index in 0..3 {
        let on_parent = if index == 0 { Vector3::zeros() } else { Vector3::new(0.0, 0.0, -0.1) };
        let joint = Joint::new(
            &format!("joint{index}"),
            JointKind::Revolute,
            models::frame(on_parent, Vector3::y()),
            models::frame(Vector3::new(0.0, 0.0, 0.1), Vector3::y()),
        );
        let mass = if index == 2 { 10.0 } else { 0.01 };
        let inertia = models::box_inertia(mass, Vector3::new(0.04, 0.04, 0.2));
        bodies.push(models::body(&format!("link{index}"), (index > 0).then(|| index - 1), mass, inertia, joint));
    }
    let mechanism = Mechanism::new("taut_chain", models::gravity(), bodies).unwrap();
    let mut state = State::zero(&mechanism);
    state.position.copy_from_slice(&[0.4, 0.02, -0.03]);
    state.velocity[0] = 20.0;
    Model { mechanism, state }
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
        let term = |(body, (pose, held)): (&catena::model::Body, (&BodyState, &Acceleration))| {
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

#[test]
fn a_fixed_step_beyond_the_limit_is_named_and_a_chosen_one_stays_below() {
    // A heavy mass at the end of three light links, turning about the hinge as fast as 20 rad/s: the links' own motion
    // across the string is some hundred times faster than what is seen.
    let model = taut_chain();
    let mechanism = &model.mechanism;
    let nearest = |mut lobatto: Lobatto, end: f64| {
        let mut state = model.state.clone();
        let ended = std::iter::from_fn(|| (state.time < end).then(|| lobatto.advance(mechanism, &mut state, end)))
            .find_map(Result::err);
        (lobatto.description().frequency_step.unwrap(), ended)
    };
    let fixed = |stages, step| nearest(Lobatto::fixed(mechanism, stages, step).unwrap(), 0.3);
    let (short, ended) = fixed(9, 1e-3);
    println!("{short:?}");
    assert!(ended.is_none() && !short.is_unstable(), "{short:?}");
    let (long, _) = fixed(3, 0.5 * short.step * 9.0);
    println!("{long:?}");
    assert!(long.is_unstable(), "{long:?}");
    for tolerance in [1e-2, 1e-4, 1e-6] {
        let (chosen, ended) = nearest(Lobatto::adaptive(mechanism, tolerance), 1.0);
        println!("{chosen:?}");
        assert!(ended.is_none() && chosen.product < 0.9 * chosen.limit, "tolerance {tolerance}: {chosen:?}");
    }
}

/// A hinge with a rod of 1 m and 1 kg, and what acts in it.
fn rod_on_a_hinge(stiffness: f64, damping: f64) -> Model {
    let joint = Joint::new("hinge", JointKind::Revolute, Pose::identity(), Pose::translation(-0.5, 0.0, 0.0));
    let rod = models::body("rod", None, 1.0, Vector3::new(0.0, 1.0 / 12.0, 1.0 / 12.0), joint);
    let mut mechanism = Mechanism::new("rod", Vector3::zeros(), vec![rod]).unwrap();
    let coordinate = Coordinate { body: 0, position: 0, freedom: 0 };
    mechanism.forces.joint_springs.push(JointSpring { coordinate, stiffness, rest: 0.0 });
    mechanism.forces.joint_dampers.push(JointDamper { freedom: 0, coefficient: damping });
    let mut state = State::zero(&mechanism);
    state.position[0] = 0.3;
    Model { mechanism, state }
}

fn mode(model: &Model, iterations: usize) -> catena::lobatto::watch::Mode {
    Linearised::new(&model.mechanism).estimate(&model.mechanism, &model.state, iterations)
}

#[test]
fn the_mode_of_a_spring_with_a_damper_is_that_of_the_textbook() {
    for (stiffness, damping) in [(1e3, 0.0), (1e3, 2.0), (1e12, 3e4), (1e-3, 1.0)] {
        let found = mode(&rod_on_a_hinge(stiffness, damping), 2);
        let inertia = 1.0_f64 / 3.0;
        let frequency = (stiffness / inertia).sqrt();
        // Differences of relative step 1e-6 of a linear function.
        assert!((found.frequency / frequency - 1.0).abs() < 1e-8, "{found:?}, {frequency}");
        let ratio = 0.5 * damping / (inertia * frequency);
        assert!((found.damping - ratio).abs() <= 1e-8 * ratio, "{found:?}, {ratio}");
    }
}

#[test]
fn without_forces_the_mode_is_that_of_the_geometric_stiffness_alone() {
    // In equilibrium, hanging and upright: elsewhere the one holds the accelerations of the bodies and the other the rates of
    // the joints.
    for angle in [0.0, std::f64::consts::PI] {
        let mut model = taut_chain();
        model.state.velocity.fill(0.0);
        model.state.position.copy_from_slice(&[angle, 0.0, 0.0]);
        let (plan, start) = start_of(&model.mechanism, &model.state);
        let mut dynamics = Dynamics::new(&plan, model.mechanism.velocity_count);
        let mut fastest = Fastest::new(model.mechanism.velocity_count);
        let expected = fastest.estimate(&mut dynamics, &plan, &start, &model.mechanism.gravity.into(), 100);
        let found = mode(&model, 100).frequency;
        // Nine digits of differences, some of them lost to the light links.
        assert!((found / expected - 1.0).abs() < 1e-6, "{found}, {expected}");
    }
}

#[test]
fn the_mode_of_a_closed_mechanism_is_that_of_its_free_motion() {
    // A parallelogram of three rods hanging straight down and up again: the cranks swing together, the coupler does not turn.
    let (mut mechanism, mut state) = closed::four_bars(1, 5);
    state.velocity.fill(0.0);
    // Upright it falls with (l/2 + l + l/2) m g on 2 m l²/3 + m l², the rods' 1 kg, 1 m.
    let gravity: f64 = 2.0 * 9.81 / (5.0 / 3.0);
    let found = mode(&Model { mechanism: mechanism.clone(), state: state.clone() }, 4);
    assert!((found.frequency / gravity.sqrt() - 1.0).abs() < 1e-6 && found.damping == 0.0, "{found:?}");
    let coordinate = Coordinate { body: 0, position: 0, freedom: 0 };
    mechanism.forces.joint_springs.push(JointSpring { coordinate, stiffness: 5e4, rest: 0.0 });
    let found = mode(&Model { mechanism, state }, 4);
    let frequency = (5e4 / (5.0 / 3.0) - gravity).sqrt();
    assert!((found.frequency / frequency - 1.0).abs() < 1e-6, "{found:?} {frequency}");
}

#[test]
fn a_spring_beyond_the_limit_is_named_from_the_first_step_and_chosen_steps_stay_below_it() {
    // 30 rad at a step of 0.1 s without a damper, and 45 with a light one: beyond the limit of 9 stages in both cases.
    for (stiffness, damping) in [(3e4, 0.0), (6.8e4, 3.0)] {
        let model = rod_on_a_hinge(stiffness, damping);
        let mut state = model.state.clone();
        let mut lobatto = Lobatto::fixed(&model.mechanism, 9, 0.1).unwrap();
        let ended = lobatto.advance(&model.mechanism, &mut state, 0.1);
        let seen = lobatto.description().frequency_step;
        assert!(
            seen.is_some_and(|seen| seen.is_unstable()) || matches!(ended, Err(StepError::Unstable { .. })),
            "{seen:?} {ended:?}"
        );
        for tolerance in [1e-2, 1e-6] {
            let mut state = model.state.clone();
            let mut lobatto = Lobatto::adaptive(&model.mechanism, tolerance);
            while state.time < 1.0 {
                lobatto.advance(&model.mechanism, &mut state, 1.0).unwrap();
            }
            let seen = lobatto.description().frequency_step.unwrap();
            assert!(!seen.is_unstable(), "tolerance {tolerance}: {seen:?}");
        }
    }
}

#[test]
fn a_damped_spring_is_stable_just_below_its_limit_and_grows_just_above() {
    for stages in [3, 5, 9] {
        let tableau = Tableau::of(stages).unwrap();
        for ratio in [0.02, 0.1, 0.5] {
            let limit = damped_limit(tableau, ratio);
            let growth = |product: f64| {
                let frequency = 100.0;
                let inertia = 1.0 / 3.0;
                let mut model = rod_on_a_hinge(inertia * frequency * frequency, 2.0 * ratio * frequency * inertia);
                model.state.position[0] = 1e-6;
                let step = product / frequency;
                let mut lobatto = Lobatto::fixed(&model.mechanism, stages, step).unwrap();
                let mut largest = [0.0_f64; 2];
                for index in 0..600 {
                    let until = model.state.time + step;
                    if lobatto.advance(&model.mechanism, &mut model.state, until).is_err() {
                        return f64::INFINITY;
                    }
                    let half = &mut largest[index / 300];
                    *half = half.max(model.state.position[0].abs());
                }
                largest[1] / largest[0]
            };
            // Found in strides of 0.05; for ½ and more the least limit of all such ratios stands for them, and the true one of ½ lies higher.
            assert!(growth(0.99 * limit) < 1.0, "{stages} stages, ratio {ratio}: grows below {limit}");
            if ratio < 0.5 {
                let grows = (1..=6).any(|hundredths| growth(limit + 0.01 * f64::from(hundredths)) > 1.0);
                assert!(grows, "{stages} stages, ratio {ratio}: stable above {limit}");
            }
        }
    }
}

#[test]
fn a_hard_damper_is_not_taken_for_a_spring() {
    // Its force turns with its line, by 1e10 N s/m times the velocity across it: no spring, since it pulls nothing back.
    let mut model = rod_on_a_hinge(0.0, 0.0);
    model.mechanism.gravity = models::gravity();
    model.mechanism.forces.point_springs.push(PointSpring {
        name: "damper".to_string(),
        a: models::point_of(None, [0.8, 0.0, 1.0]),
        b: models::point_of(Some(0), [0.5, 0.0, 0.0]),
        stiffness: 0.0,
        damping: 1e10,
        rest_length: 1.0,
    });
    model.state.velocity[0] = 2.0;
    let found = mode(&model, 4);
    assert!(found.frequency < 10.0, "{found:?}");
}

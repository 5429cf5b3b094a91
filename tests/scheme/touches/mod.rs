//! Closed contacts: friction, rolling and every pair of features, each against an exact or an independent answer.

mod control;
mod derivatives;
mod elimination;
mod features;
mod literal;
mod moments;
mod rolling;
mod sliding;
mod slip_onset;

use catena::mechanism::description::closure::Attachment;
use catena::mechanism::description::contact::{Feature, Grip, Moments, Touch, TouchJoint};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::energy::{energy, violation};
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::Lobatto;
use nalgebra::{Rotation3, Translation3, Vector3};

/// Sliding with a coefficient of friction, from some slip.
fn slides(friction: f64) -> Grip {
    Grip::Slides { friction, direction: Vector3::zeros() }
}

/// A feature of a body, or of the world, at a place and with its axis turned by a rotation vector.
fn feature(body: Option<usize>, place: Vector3<f64>, turn: Vector3<f64>) -> Attachment {
    Attachment { body, frame: Pose::from_parts(Translation3::from(place), Rotation3::new(turn)) }
}

/// A contact of two features.
fn touch(features: [Feature; 2], grip: Grip, a: Attachment, b: Attachment) -> TouchJoint {
    TouchJoint {
        reeved: Vec::new(),
        touch: Touch { features, side: 1.0, grip },
        a,
        b,
        surfaces: [Vector3::zeros(); 2],
        moments: Moments::default(),
    }
}

/// A point of a body, with a radius, on the floor.
fn on_floor(body: usize, place: Vector3<f64>, radius: f64, grip: Grip) -> TouchJoint {
    let floor = feature(None, Vector3::zeros(), Vector3::zeros());
    touch([Feature::Plane, Feature::Point { radius }], grip, floor, feature(Some(body), place, Vector3::zeros()))
}

/// Free bodies with these masses and inertias.
fn free(gravity: Vector3<f64>, bodies: &[(f64, Vector3<f64>)]) -> Mechanism {
    let body = |(number, &(mass, inertia)): (usize, &(f64, Vector3<f64>))| {
        let name = format!("body{number}");
        let joint = Joint::new(&name, JointKind::Floating, Pose::identity(), Pose::identity());
        Body { name, parent: None, mass, inertia, joint }
    };
    Mechanism::new("touches", gravity, bodies.iter().enumerate().map(body).collect()).unwrap()
}

/// Sets place, turn, velocity and angular velocity (in the axes of the body) of a free body.
fn set(state: &mut State, body: usize, place: [f64; 3], turn: Vector3<f64>, velocity: [f64; 3], spin: [f64; 3]) {
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(turn);
    state.position[7 * body..7 * body + 3].copy_from_slice(&place);
    state.position[7 * body + 3..7 * body + 7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
    state.velocity[6 * body..6 * body + 3].copy_from_slice(&velocity);
    state.velocity[6 * body + 3..6 * body + 6].copy_from_slice(&spin);
}

/// What a run ended with: iterations a step, the largest gap and rate of a contact at the ends of steps, and the energy lost to nothing (J).
struct Ran {
    iterations: f64,
    gap: f64,
    rate: f64,
    lost: f64,
}

/// Runs to a time with equal steps.
fn run(mechanism: &Mechanism, state: &mut State, stages: usize, steps: usize, until: f64) -> Ran {
    let total = |state: &State| energy(mechanism, &body_states(mechanism, state)).total();
    let mut lobatto = Lobatto::fixed(mechanism, stages, until / steps as f64).unwrap();
    let (before, mut iterations, mut made, mut given) = (total(state), 0, 0, 0.0);
    let (mut gap, mut rate) = (0.0_f64, 0.0_f64);
    while state.time < until {
        let outcome = lobatto.advance(mechanism, state, until).unwrap();
        (iterations, made, given) = (iterations + outcome.cost.iterations, made + 1, given + outcome.exchange.lost());
        let worst = violation(mechanism, state, &body_states(mechanism, state));
        (gap, rate) = (gap.max(worst.position), rate.max(worst.velocity));
    }
    Ran { iterations: iterations as f64 / made as f64, gap, rate, lost: total(state) - before + given }
}

/// Runs with numbers of steps that double, and asserts that errors fall to the order 2s − 2: to within half of it, or with nine stages and where
/// they are that small to below `floor`; and that gaps, rates and what Newton's method costs stay small.
fn assert_order(
    (mechanism, start): (&Mechanism, &State),
    until: f64,
    floor: f64,
    counts: [(usize, [usize; 3]); 3],
    error: impl Fn(&State) -> f64,
) {
    for (stages, counts) in counts {
        let errors = counts.map(|steps| {
            let mut state = start.clone();
            let ran = run(mechanism, &mut state, stages, steps, until);
            let Ran { iterations, gap, rate, lost } = ran;
            let error = error(&state);
            println!("s = {stages}, {steps} steps: {error:.2e}, {iterations:.1} iterations, {gap:.1e}, {rate:.1e}, lost {lost:.1e}");
            // A few roundings of places below 1 m and of rates below 10 m/s.
            assert!(gap < 5e-15 && rate < 5e-14, "s = {stages}: gap {gap:e}, rate {rate:e}");
            // Exact but for curvature the method takes 4 to 6; 15 is where its patience ends.
            assert!(iterations < 12.0, "s = {stages}, {steps} steps: {iterations} iterations");
            error
        });
        let order = (2 * stages - 2) as f64;
        for pair in errors.windows(2) {
            let seen = (pair[0] / pair[1]).log2();
            assert!(seen > order - 0.5 || pair[1] < floor, "s = {stages}: order {seen} from {errors:?}");
        }
        assert!(stages < 9 || errors[2] < floor, "s = {stages}: {errors:?}");
    }
}

//! Reversible steps: a run that is turned round retraces itself, and its energy has no trend.

use crate::models::{self, Model};
use catena::mechanism::description::body_state::WORLD;
use catena::mechanism::description::joint::{Joint, JointKind};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::forward_kinematics;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::{Lobatto, MethodError};
use nalgebra::Vector3;

/// Steps made, their lengths, and the state at the end.
fn steps(model: &Model, start: &State, first: f64, count: usize) -> (Vec<f64>, State, usize) {
    let mut lobatto = Lobatto::reversible(&model.mechanism, 5, first).unwrap();
    let mut state = start.clone();
    let lengths =
        (0..count).map(|_| lobatto.advance(&model.mechanism, &mut state, f64::INFINITY).unwrap().step).collect();
    (lengths, state, lobatto.description().reversible_resets.unwrap())
}

#[test]
fn a_run_that_is_turned_round_retraces_its_steps() {
    for model in [models::double_pendulum(), models::floating_tree()] {
        let count = 60;
        let (there, mut turned, resets) = steps(&model, &model.state, 0.04, count);
        assert_eq!(resets, 0);
        let (least, most) = there.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &step| (a.min(step), b.max(step)));
        assert!(most > 1.3 * least, "{}: the steps do not vary: {least} to {most}", model.mechanism.name);
        turned.velocity.iter_mut().for_each(|rate| *rate = -*rate);
        let last = there[count - 1];
        let (back, end, _) = steps(&model, &turned, last, count);
        for (step, expected) in back.iter().zip(there.iter().rev()) {
            assert!((step - expected).abs() < 1e-9 * expected, "{}: {step}, was {expected}", model.mechanism.name);
        }
        // Rounding, amplified by the motion for some seconds.
        let apart =
            end.position.iter().zip(&model.state.position).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(apart < 1e-8, "{}: {apart:.1e}", model.mechanism.name);
    }
}

/// Two pi over the frequency of small swings of the pendulum below [s], times what swinging to 2.5 rad adds.
const PERIOD: f64 = 2.7;

/// A rod of 1 m on a hinge that swings to 2.5 rad, where its pace varies by a factor of two.
fn pendulum() -> Model {
    let frame = |place: f64| models::frame(Vector3::new(0.0, 0.0, place), Vector3::y());
    let joint = Joint::new("hinge", JointKind::Revolute, frame(0.0), frame(0.5));
    let rod = models::body("rod", None, 1.0, Vector3::new(1.0, 1.0, 0.0) / 12.0, joint);
    let mechanism = Mechanism::new("pendulum", models::gravity(), vec![rod]).unwrap();
    let mut state = State::zero(&mechanism);
    state.position[0] = 2.5;
    Model { mechanism, state }
}

/// Largest energy error and its mean, relative to the largest kinetic energy, in ten windows of a run; mean step and resets.
fn energy_windows(model: &Model, mut lobatto: Lobatto, duration: f64) -> ([f64; 10], [f64; 10], f64, Option<usize>) {
    let mechanism = &model.mechanism;
    let mut state = model.state.clone();
    let mut bodies = vec![WORLD; mechanism.bodies.len()];
    let mut energy = |state: &State| {
        forward_kinematics(mechanism, &state.position, &state.velocity, &mut bodies);
        catena::mechanism::motion::energy::energy(mechanism, &bodies)
    };
    let initial = energy(&state).total();
    let (mut largest, mut sums, mut spans, mut kinetic) = ([0.0_f64; 10], [0.0; 10], [0.0; 10], 0.0_f64);
    while state.time < duration {
        let step = lobatto.advance(mechanism, &mut state, duration).unwrap().step;
        let now = energy(&state);
        kinetic = kinetic.max(now.kinetic);
        let window = ((10.0 * state.time / duration) as usize).min(9);
        let error = now.total() - initial;
        largest[window] = largest[window].max(error.abs());
        // The mean over time, not over steps, which are not alike.
        sums[window] += step * error;
        spans[window] += step;
    }
    let description = lobatto.description();
    let means = std::array::from_fn(|window| sums[window] / (spans[window] * kinetic));
    (largest.map(|error| error / kinetic), means, description.step, description.reversible_resets)
}

/// Numbers for people.
fn listed(numbers: &[f64]) -> String {
    numbers.iter().map(|number| format!("{number:.2e}")).collect::<Vec<_>>().join(" ")
}

fn check(periods: f64) {
    let model = pendulum();
    let run = |name: &str, lobatto: Lobatto| {
        let clock = cpu_time::ThreadTime::now();
        let (largest, means, step, resets) = energy_windows(&model, lobatto, PERIOD * periods);
        let micros = 1e6 * clock.elapsed().as_secs_f64() / (PERIOD * periods);
        println!("{name}: mean step {step:.4}, {micros:.1} us CPU/s, resets {resets:?}");
        println!("    largest errors {}\n    means {}", listed(&largest), listed(&means));
        (largest, means, resets)
    };
    let mut worst = 0.0_f64;
    for (stages, step) in [(3, 0.05), (5, 0.25)] {
        let reversible = Lobatto::reversible(&model.mechanism, stages, step).unwrap();
        let (largest, means, resets) = run(&format!("reversible, {stages} stages"), reversible);
        assert_eq!(resets, Some(0));
        let top = largest.iter().copied().fold(0.0, f64::max);
        // No trend: neither the largest error nor its mean moves from the first tenth to any other by more than a few
        // hundredths of the error itself.
        assert!(top < 1.1 * largest[0], "largest errors {}", listed(&largest));
        assert!(means.iter().all(|mean| (mean - means[0]).abs() < 0.05 * top), "means {}", listed(&means));
        worst = worst.max(top);
        // Without a bound from above garbage would have no trend either, without one from below nothing could be seen.
        assert!((1e-7..1e-3).contains(&top), "{top:.1e}");
    }
    // The ordinary controller drifts.
    let ordinary = Lobatto::adaptive_with_stop(&model.mechanism, 1e-4, 1e-6);
    let (largest, means, _) = run("tolerance", ordinary);
    assert!((means[9] - means[0]).abs() > 0.5 * largest[9], "means {}", listed(&means));
    assert!(means[9].abs() > 0.5 * largest[9], "means {}", listed(&means));
    // A thousand periods make it some twenty times the error of the reversible steps.
    assert!(largest[9] > 10.0 * worst, "largest errors {}", listed(&largest));
}

#[test]
fn energy_has_no_trend_over_a_thousand_periods_with_reversible_steps_and_one_with_the_ordinary_control() {
    check(1e3);
}

#[test]
#[ignore = "half a minute: cargo test --release --test scheme reversible:: -- --ignored --nocapture"]
fn energy_has_no_trend_over_a_hundred_thousand_periods_with_reversible_steps() {
    check(1e5);
}

#[test]
fn what_is_not_reversible_itself_is_refused() {
    let mut model = models::double_pendulum();
    let damper = catena::mechanism::description::forces::JointDamper { freedom: 0, coefficient: 0.1 };
    model.mechanism.forces.joint_dampers.push(damper);
    assert_eq!(Lobatto::reversible(&model.mechanism, 5, 0.01).err(), Some(MethodError::NotReversible));
}

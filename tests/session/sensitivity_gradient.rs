//! Gradients of losses of samples against time, by forward derivatives of the same runs.

use crate::robot;
use catena::prelude::*;
use catena::session::{Backward, EventLost, Lost, Samples, Sensitivity};

/// Numbers in (−1, 1) that look random.
fn number(seed: usize) -> f64 {
    (12.9898 * seed as f64 + 1.0).sin()
}

/// A sum of all q and v of the samples with weights, and its derivatives.
fn weighted(samples: &Samples) -> Lost {
    let mut lost = Lost::default();
    for (index, (q, v)) in samples.q.iter().zip(&samples.v).enumerate() {
        let weights = |of: &[f64], seed: usize| (0..of.len()).map(|row| number(seed + 17 * index + row)).collect();
        let (by_q, by_v): (Vec<f64>, Vec<f64>) = (weights(q, 5), weights(v, 500));
        let sum = |of: &[f64], by: &[f64]| of.iter().zip(by).map(|(of, by)| of * by).sum::<f64>();
        lost.value += sum(q, &by_q) + sum(v, &by_v);
        lost.by_q.push(by_q);
        lost.by_v.push(by_v);
    }
    lost
}

/// The same sum of forward derivatives, at the start, at every third step and at the end, with the size of its parts.
fn by_forward(run: &Sensitivity) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let rows: Vec<usize> = (0..run.times.len()).filter(|row| row % 3 == 0 || row + 1 == run.times.len()).collect();
    let (mut sums, mut sizes) = (vec![0.0; run.keys.len()], vec![0.0; run.keys.len()]);
    for (index, &row) in rows.iter().enumerate() {
        for (of, seed) in [(&run.dq[row], 5), (&run.dv[row], 500)] {
            for (freedom, slopes) in of.row_iter().enumerate() {
                let weight = number(seed + 17 * index + freedom);
                for (key, slope) in slopes.iter().enumerate() {
                    sums[key] += weight * slope;
                    sizes[key] += (weight * slope).abs();
                }
            }
        }
    }
    (rows.iter().map(|&row| run.times[row]).collect(), sums, sizes)
}

fn assert_same(name: &str, keys: &[&str], run: impl Fn() -> Simulation, bound: f64) {
    let forward = run().sensitivity(keys).unwrap_or_else(|error| panic!("{name}: {error}"));
    let (times, sums, sizes) = by_forward(&forward);
    let gradient = |every: usize| {
        let asked = Backward { keys, times: &times, every };
        run().gradient(&asked, weighted).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    let all = gradient(1);
    assert_eq!(all.keys, forward.keys);
    for (key, (by, (sum, size))) in all.by.iter().zip(sums.iter().zip(&sizes)).enumerate() {
        let apart = (by - sum).abs() / size.max(1e-12);
        assert!(apart < bound, "{name}, {}: {by} and {sum}, apart by {apart:.1e}", all.keys[key]);
    }
    // States are computed again from the same numbers by the same arithmetic.
    assert_eq!(gradient(4), all, "{name}: the gradient does not depend on what the tape keeps");
    assert_eq!(gradient(1000), all, "{name}: also if only the start is kept");
}

#[test]
fn gradients_of_an_arm_through_impacts_on_its_limits_are_its_forward_derivatives() {
    let model = Model::load(robot("arm7.urdf")).expect("a model");
    let keys = [
        "start.q",
        "start.v",
        "effort.joint2",
        "link.forearm.mass",
        "link.upper_arm.center_of_mass.x",
        "link.wrist.inertia.ixx",
        "gravity.z",
    ];
    // Three impacts, which enlarge roundings a hundred times until 0.7 s.
    assert_same("arm", &keys, || Simulation::new(&model).duration(0.7).without_figures(), 1e-10);
}

#[test]
fn gradients_of_springs_dampers_and_motors_are_their_forward_derivatives() {
    let oscillator = Model::load(robot("damped_oscillator.toml")).expect("a model");
    let keys = ["start.q", "start.v", "effort.slide", "spring.stiffness", "spring.damping"];
    let run = || Simulation::new(&oscillator).fixed(5, 0.05).duration(1.0);
    assert_same("oscillator", &keys, run, 1e-12);
    let held = Model::load(robot("arm7_held.toml")).expect("a model");
    let keys = ["start.q", "link.forearm.mass", "gravity.z"];
    assert_same("held arm", &keys, || Simulation::new(&held).fixed(5, 0.01).duration(0.2).without_figures(), 1e-11);
}

#[test]
fn gradients_of_dry_friction_and_closed_loops_are_their_forward_derivatives() {
    let pendulum = Model::load(robot("friction_pendulum.toml")).expect("a model");
    assert_same("friction", &["start.q", "start.v"], || Simulation::new(&pendulum).fixed(5, 0.05).duration(2.0), 1e-11);
    let loops = Model::load(robot("four_bar_1.toml")).expect("a model");
    assert_same("loop", &["gravity.z"], || Simulation::new(&loops).fixed(4, 0.02).duration(0.2), 1e-11);
}

#[test]
fn derivatives_that_are_zero_by_symmetry_stay_zero_to_rounding_forward_and_backward() {
    // Under gravity alone the motion does not depend on the angle of the first joint, which turns about the vertical.
    let model = Model::load(robot("arm7.urdf")).expect("a model");
    let run = || Simulation::new(&model).fixed(5, 0.01).duration(0.3).without_figures();
    let forward = run().sensitivity(&["start.q"]).expect("derivatives");
    assert_eq!(forward.freedoms[0], "joint1");
    for (step, (dq, dv)) in forward.dq.iter().zip(&forward.dv).enumerate() {
        let size = dq.amax().max(dv.amax());
        assert!((dq[(0, 0)] - 1.0).abs() < 1e-13 * size, "step {step}: the angle itself moves along");
        let most = dq.column(0).rows_range(1..).amax().max(dv.column(0).amax());
        // Some hundred roundings of 1e-16, which 30 steps enlarge ten times.
        assert!(most < 1e-13 * size, "step {step}: {most:.1e} of {size:.1e}");
    }
    // All of the end but that angle.
    let loss = |samples: &Samples| {
        let mut lost = weighted(samples);
        lost.by_q.iter_mut().for_each(|by| by[0] = 0.0);
        lost
    };
    let backward = run().gradient(&Backward { keys: &["start.q"], times: &[0.3], every: 1 }, loss).expect("a gradient");
    let size = backward.by.iter().fold(0.0, |size: f64, by| size.max(by.abs()));
    assert!(backward.by[0].abs() < 1e-13 * size, "{:.1e} of {size:.1e}", backward.by[0]);
}

#[test]
fn the_times_of_events_and_the_states_at_them_are_parts_of_a_loss() {
    let ball = Model::load(robot("ball_dropped.toml")).expect("a model");
    let keys = ["start.q", "start.v", "floor.restitution", "gravity.z"];
    let run = || Simulation::new(&ball).fixed(5, 0.05).duration(1.2);
    let forward = run().sensitivity(&keys).expect("derivatives");
    assert!(forward.events.len() >= 2, "{:?}", forward.events);
    // The time of each event and all of q and v at it, with weights.
    let weights = |event: usize, n: usize| {
        let of = |seed: usize| (0..n).map(|row| number(seed + 31 * event + row)).collect::<Vec<f64>>();
        EventLost { event, time: number(event), by_q: of(60), by_v: of(600) }
    };
    let loss = |samples: &Samples| {
        let mut lost = Lost { by_q: vec![vec![0.0; 6]], by_v: vec![vec![0.0; 6]], ..Lost::default() };
        lost.by_events = (0..samples.events.len()).map(|event| weights(event, 6)).collect();
        lost.value = samples.events.iter().map(|event| event.time).sum();
        lost
    };
    for every in [1, 7] {
        let backward = run().gradient(&Backward { keys: &keys, times: &[1.2], every }, loss).expect("a gradient");
        let times: f64 = forward.events.iter().map(|event| event.time).sum();
        assert!((backward.value - times).abs() < 1e-12, "the events are those of the run");
        for (key, name) in forward.keys.iter().enumerate() {
            let (mut sum, mut size) = (0.0, 1e-12);
            for (index, event) in forward.events.iter().enumerate() {
                let by = weights(index, 6);
                let products = |weights: &[f64], of: &nalgebra::DMatrix<f64>| -> Vec<f64> {
                    weights.iter().zip(of.column(key)).map(|(weight, slope)| weight * slope).collect()
                };
                let parts =
                    [vec![by.time * event.by[key]], products(&by.by_q, &event.dq), products(&by.by_v, &event.dv)];
                for part in parts.iter().flatten() {
                    (sum, size) = (sum + part, f64::max(size, part.abs()));
                }
            }
            // The same products in another order, through two impacts.
            let apart = (backward.by[key] - sum).abs() / size;
            assert!(apart < 1e-12, "{name}: {} and {sum}", backward.by[key]);
        }
    }
    // The first impact: t = √(2 h/g), where the ball falls from rest; ∂t/∂h = 1/(g t).
    let first = |samples: &Samples| {
        let [by_q, by_v] = [vec![vec![0.0; 6]], vec![vec![0.0; 6]]];
        let by_events = vec![EventLost { event: 0, time: 1.0, ..EventLost::default() }];
        Lost { value: samples.events[0].time, by_q, by_v, by_events }
    };
    let asked = Backward { keys: &["start.q"], times: &[1.2], every: 1 };
    let found = run().gradient(&asked, first).expect("a gradient");
    let exact = 1.0 / (9.81 * found.value);
    assert!((found.by[2] - exact).abs() < 1e-12, "{} and {exact}", found.by[2]);
    let late = |_: &Samples| Lost {
        by_events: vec![EventLost { event: 99, ..EventLost::default() }],
        by_q: vec![vec![0.0; 6]],
        by_v: vec![vec![0.0; 6]],
        value: 0.0,
    };
    let late = run().gradient(&asked, late).expect_err("no such event").to_string();
    assert!(late.contains("events up to the one of the loss"), "{late}");
}

#[test]
fn samples_outside_a_run_and_losses_of_another_size_are_refused() {
    let model = Model::load(robot("double_pendulum.urdf")).expect("a model");
    let run = || Simulation::new(&model).fixed(3, 0.05).duration(0.5);
    let asked = |times| Backward { keys: &["start.q"], times, every: 1 };
    let late = run().gradient(&asked(&[0.7]), weighted).expect_err("a time after the end").to_string();
    assert!(late.contains("give times after its start"), "{late}");
    let wrong = run().gradient(&asked(&[0.5]), |_| Lost::default()).expect_err("no rows").to_string();
    assert!(wrong.contains("derivatives of the loss by q"), "{wrong}");
}

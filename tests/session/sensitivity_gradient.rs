//! Gradients of losses of samples against time, by forward derivatives of the same runs.

use crate::robot;
use catena::prelude::*;
use catena::session::{Backward, Lost, Samples, Sensitivity};

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

/// The same sum of forward derivatives, at every third step and the end, with the size of its parts.
fn by_forward(run: &Sensitivity) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let rows: Vec<usize> = (1..run.times.len()).filter(|row| row % 3 == 0 || row + 1 == run.times.len()).collect();
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
fn samples_outside_a_run_and_losses_of_another_size_are_refused() {
    let model = Model::load(robot("double_pendulum.urdf")).expect("a model");
    let run = || Simulation::new(&model).fixed(3, 0.05).duration(0.5);
    let asked = |times| Backward { keys: &["start.q"], times, every: 1 };
    let late = run().gradient(&asked(&[0.7]), weighted).expect_err("a time after the end").to_string();
    assert!(late.contains("give times after its start"), "{late}");
    let wrong = run().gradient(&asked(&[0.5]), |_| Lost::default()).expect_err("no rows").to_string();
    assert!(wrong.contains("derivatives of the loss by q"), "{wrong}");
}

//! Closed mechanisms move as published, at the order of the scheme, with gaps of rounding however often they turn;
//! their joints carry what they should.

#![allow(clippy::excessive_precision, reason = "reference values stand as their source prints them")]

use super::{run, run_keeping};
use crate::closed;
use catena::instant::exerting::reactions::Reactions;
use catena::instant::start::assembly::{assemble, redundancy};
use catena::mechanism::description::closure::LoopJoint;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::Lobatto;
use nalgebra::Vector3;

/// Where the end of the first crank is.
fn tip(mechanism: &Mechanism, state: &State) -> Vector3<f64> {
    let crank = &body_states(mechanism, state)[0];
    crank.position + crank.rotation * Vector3::new(0.5, 0.0, 0.0)
}

/// Error of the tip of a four-bar at t = 1 s; the exact value solves the equation of one angle of problem A02 of the IFToMM library, N = 1.
fn four_bar_error(kept: &[Rule], rows: usize, stages: usize, step: f64) -> f64 {
    let (mechanism, mut state) = closed::four_bars(1, rows);
    run_keeping(kept, &mechanism, &mut state, stages, step, 1.0);
    (tip(&mechanism, &state) - Vector3::new(-0.26071267518365038, 0.0, -0.96541643915907316)).norm()
}

#[test]
fn a_four_bar_keeps_the_order_of_the_scheme_however_many_of_its_equations_are_redundant() {
    // The coarse errors are those of a dense prototype of the scheme; 1.2 allows for its two digits.
    for (stages, coarse_error) in [(2, 1.4e-1), (3, 8.0e-4), (4, 5.8e-6), (5, 3.0e-8)] {
        let errors = |kept: &[Rule], rows| [0.1, 0.05].map(|step| four_bar_error(kept, rows, stages, step));
        let [few, many] = [3, 5].map(|rows| errors(&[Rule::Planar], rows));
        assert!(many[0] < 1.2 * coarse_error, "s = {stages}: {:e}", many[0]);
        // 4, 16, 64, 256, but for the next order's share.
        let ratio = many[0] / many[1];
        let expected = 4.0_f64.powi(stages as i32 - 1);
        assert!((0.7 * expected..1.5 * expected).contains(&ratio), "s = {stages}: ratio {ratio}");
        // One motion: what differs is rounding, amplified by the passage through the singular position.
        assert!((few[1] - many[1]).abs() < 1e-11, "s = {stages}: {:e} and {:e}", few[1], many[1]);
        // In the plane, where all are independent.
        for (flat, full) in errors(&[], 5).into_iter().zip(many) {
            assert!((flat - full).abs() < 1e-11, "s = {stages}: {flat:e} and {full:e}");
        }
    }
}

#[test]
fn bricard_moves_as_published_with_its_redundant_equation() {
    let (mechanism, start) = closed::bricard();
    let found = redundancy(&mechanism, &start);
    assert_eq!((found.count(), found.degrees_of_freedom(&mechanism)), (1, 1), "{found:?}");
    // The prototype's 5.2e-10 at s = 4, and a converged step.
    for (stages, step, bound) in [(4, 0.08, 6e-10), (9, 0.16, 1e-12)] {
        let mut state = start.clone();
        let (iterations, gap) = run(&mechanism, &mut state, stages, step, 2.4);
        let rod = &body_states(&mechanism, &state)[1];
        let corner = rod.position + rod.rotation * Vector3::new(0.0, -0.5, 0.0);
        let published = Vector3::new(-0.9910312231896985, -0.99996013963756425, -0.0089285573315649579);
        let error = (corner - published).norm();
        println!("s = {stages}: error {error:.2e}, {iterations:.1} iterations a step, gap {gap:.1e}");
        assert!(error < bound, "s = {stages}: {error:e}");
        assert!(gap < 3e-15, "{gap:e}");
    }
}

#[test]
fn forty_four_bars_reach_the_published_motion_in_long_steps() {
    // N = 40 is symmetric: the motion is that of one angle; (N+1)/3 + N = 53.67, (N+1)/2 + N = 60.5 (problem A02 of the IFToMM library).
    let (mechanism, mut state) = closed::four_bars(40, 5);
    let (_, gap) = run(&mechanism, &mut state, 5, 0.04, 2.0);
    let (mut angle, mut rate) = (std::f64::consts::FRAC_PI_2, -1.0_f64);
    let acceleration = |angle: f64| -9.81 * 60.5 * angle.cos() / (41.0 / 3.0 + 40.0);
    let steps = 20_000;
    let step = 2.0 / steps as f64;
    for _ in 0..steps {
        // Classical Runge–Kutta: 1e-4 s leaves 1e-13.
        let (k1, l1) = (rate, acceleration(angle));
        let (k2, l2) = (rate + 0.5 * step * l1, acceleration(angle + 0.5 * step * k1));
        let (k3, l3) = (rate + 0.5 * step * l2, acceleration(angle + 0.5 * step * k2));
        let (k4, l4) = (rate + step * l3, acceleration(angle + step * k3));
        angle += step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        rate += step / 6.0 * (l1 + 2.0 * (l2 + l3) + l4);
    }
    let error = (tip(&mechanism, &state) - Vector3::new(angle.cos(), 0.0, angle.sin())).norm();
    println!("error {error:.2e}, gap {gap:.1e}");
    assert!(error < 1e-10, "{error:e}");
    // The row is 41 m long, and a double resolves 7e-15 m there.
    assert!(gap < 1e-13, "{gap:e}");
}

#[test]
fn dense_output_stays_on_the_loops() {
    let (mechanism, mut state) = closed::bricard();
    let mut lobatto = Lobatto::fixed(&mechanism, 4, 0.1).unwrap();
    let mut inside = state.clone();
    while state.time < 0.5 {
        let start = state.time;
        lobatto.advance(&mechanism, &mut state, 0.5).unwrap();
        for part in [0.1, 0.37, 0.81] {
            let time = start + part * (state.time - start);
            lobatto.dense(&mechanism, time, &mut inside.position, &mut inside.velocity);
            let (gap, rate) = loop_gaps(&mechanism.loops[0], &body_states(&mechanism, &inside)).largest();
            assert!(gap < 1e-14 && rate < 1e-13, "{gap:e} {rate:e}");
        }
    }
}

#[test]
#[ignore = "a minute; cargo test --release --test scheme loops:: -- --ignored"]
fn the_gap_of_bricard_is_rounding_after_a_million_steps() {
    let (mechanism, mut state) = closed::bricard();
    let (_, gap) = run(&mechanism, &mut state, 4, 0.01, 1e4);
    assert!(gap < 1e-14, "{gap:e}");
}

#[test]
fn a_loop_that_is_closed_sixteen_times_over_moves_as_if_closed_once() {
    let (mechanism, mut state) = closed::four_bars(1, 5);
    let mut crowded = (mechanism.clone(), state.clone());
    for copy in 1..16 {
        let name = format!("copy{copy}");
        crowded.0.loops.push(LoopJoint { name, ..mechanism.loops[0].clone() });
    }
    run(&mechanism, &mut state, 5, 0.02, 0.6);
    run(&crowded.0, &mut crowded.1, 5, 0.02, 0.6);
    let largest = state.position.iter().zip(&crowded.1.position).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    // Thirty steps, each iterated to rounding.
    assert!(largest < 1e-13, "{largest:e}");
    let redundant = redundancy(&crowded.0, &crowded.1).redundant;
    assert_eq!(redundant.iter().map(|(_, count)| count).sum::<usize>(), 78, "{redundant:?}");
}

#[test]
fn the_gap_is_rounding_however_often_the_joints_have_turned() {
    // After ten thousand turns a double knows an angle to 7e-12 rad only; what its roundings leave out is kept too.
    let (mechanism, mut state) = closed::four_bars(1, 5);
    let turns = 1e4 * std::f64::consts::TAU;
    state.position[0] += turns;
    state.position[1] -= turns;
    state.position[2] += turns;
    assemble(&mechanism, &mut state).unwrap();
    let (_, gap) = run(&mechanism, &mut state, 4, 0.01, 5.0);
    assert!(gap < 1e-14, "{gap:e}");
}

#[test]
fn the_feet_of_a_closed_frame_carry_its_weight_and_its_momentum() {
    // Bricard's mechanism hangs on the world by its first hinge and by its loop: together they change its momentum.
    let (mechanism, mut state) = closed::bricard();
    run(&mechanism, &mut state, 5, 0.05, 0.7);
    let mut reactions = Reactions::new(&mechanism);
    let (joints, loops) = reactions.at(&state.position, &state.velocity);
    let momentum =
        |state: &State| catena::mechanism::motion::energy::momentum(&mechanism, &body_states(&mechanism, state)).0;
    let rate = {
        // Central difference over 2e-4 s: 1e-7 of an acceleration's change.
        let step = 1e-4;
        let mut after = state.clone();
        run(&mechanism, &mut after, 5, step, state.time + step);
        let mut before = state.clone();
        before.velocity.iter_mut().for_each(|rate| *rate = -*rate);
        run(&mechanism, &mut before, 5, step, state.time + step);
        // Backwards in time momenta are opposite.
        (momentum(&after) + momentum(&before)) / (2.0 * step)
    };
    let weight = mechanism.gravity * mechanism.total_mass();
    // The loop's first end is on the rod, the second is the world's: what the world gives is the opposite.
    let carried = joints[0].force - loops[0].force;
    assert!((carried + weight - rate).norm() < 1e-4, "{carried} {weight} {rate}");
}

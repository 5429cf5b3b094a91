//! Singular positions are passed on the branch that inertia dictates, and a start in one is decided by its motion alone.

use super::{run, run_keeping, total_energy};
use crate::closed;
use catena::instant::start::assembly::{AssemblyError, assemble};
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::Lobatto;
use nalgebra::Vector3;

/// Runs N four-bars with many step sizes through their singular positions (all bars in line, twice a revolution).
fn pass_singular_positions(kept: &[Rule], count: usize, stages: usize, sizes: usize, until: f64) {
    for size in 0..sizes {
        let step = 0.005 * 10.0_f64.powf((size as f64 + 0.37) / sizes as f64);
        let (mechanism, mut state) = closed::four_bars(count, 5);
        let start = total_energy(&mechanism, &state);
        let (_, gap) = run_keeping(kept, &mechanism, &mut state, stages, step, until);
        assert!(gap < 1e-13, "step {step}: gap {gap:e}");
        let bodies = body_states(&mechanism, &state);
        for crank in 1..=count {
            // On the branch that inertia dictates all cranks stay parallel; on another one they are radians apart.
            let apart = (bodies[2 * crank].rotation - bodies[0].rotation).norm();
            assert!(apart < 1e-4, "step {step}: crank {crank} has left by {apart:e}");
        }
        // 2e-4 J of 40 J is the truncation error of the largest step with s = 4; a blip at the position would be of the
        // order of the kinetic energy.
        let drift = (total_energy(&mechanism, &state) - start).abs();
        assert!(drift < 2e-4 * (count as f64 + 1.0), "step {step}: energy off by {drift:e}");
    }
}

#[test]
fn singular_positions_are_passed_on_the_right_branch_at_any_step_size() {
    for (count, stages) in [(1, 4), (1, 9), (2, 5)] {
        // In the plane, and with its redundant equations in space.
        pass_singular_positions(&[], count, stages, 25, 1.3);
        pass_singular_positions(&[Rule::Planar], count, stages, 25, 1.3);
    }
}

#[test]
fn no_step_jumps_to_another_branch_of_a_singular_position() {
    // With this step the equations of one step have a second solution, more than a metre off.
    let (mechanism, start) = closed::four_bars(5, 5);
    for kept in [&[][..], &[Rule::Planar]] {
        let mut state = start.clone();
        run_keeping(kept, &mechanism, &mut state, 9, 0.032570206556597835, 5.0);
        let energy = total_energy(&mechanism, &start);
        let drift = (total_energy(&mechanism, &state) - energy).abs();
        assert!(drift < 1e-4 * energy, "energy off by {drift:e} J");
        let bodies = body_states(&mechanism, &state);
        for crank in 1..=5 {
            assert!((bodies[2 * crank].rotation - bodies[0].rotation).norm() < 1e-4, "crank {crank} has left");
        }
    }
}

#[test]
#[ignore = "minutes; cargo test --release --test scheme loops:: -- --ignored"]
fn singular_positions_are_passed_at_two_hundred_step_sizes() {
    for count in [1, 2] {
        for stages in [4, 5, 9] {
            pass_singular_positions(&[], count, stages, 200, 5.0);
            pass_singular_positions(&[Rule::Planar], count, stages, 200, 5.0);
        }
    }
    pass_singular_positions(&[], 10, 5, 40, 5.0);
    pass_singular_positions(&[Rule::Planar], 10, 5, 40, 5.0);
}

#[test]
fn a_start_at_rest_in_a_singular_position_is_undecided_and_said_to_be() {
    for count in [1, 2] {
        let (mechanism, mut state) = closed::four_bars(count, 5);
        // All bars in line: cranks and couplers point along x.
        state.position.fill(0.0);
        state.velocity.fill(0.0);
        let error = assemble(&mechanism, &mut state.clone()).unwrap_err();
        assert_eq!(error, AssemblyError::Undecided { extra: count });
        // Inertia decides.
        let (_, moving) = closed::four_bars(count, 5);
        state.velocity.copy_from_slice(&moving.velocity);
        assemble(&mechanism, &mut state).unwrap();
        let start = total_energy(&mechanism, &state);
        run(&mechanism, &mut state, 5, 0.02, 0.3);
        let bodies = body_states(&mechanism, &state);
        assert!((bodies[2].rotation - bodies[0].rotation).norm() < 1e-6, "the cranks stay parallel");
        // One loop: no trace. Two: where the first stage lies exactly on the position its multipliers have no lever, and
        // the step leaves some 1e-5 J of 30 J behind, once; 1e-10 rad beside it nothing of it is left.
        let left_behind = (total_energy(&mechanism, &state) - start).abs();
        assert!(left_behind < [1e-12, 2e-5][count - 1], "{count}: {left_behind:e}");
        // A milliradian beside it at rest is decided.
        let mut beside = State::zero(&mechanism);
        for crank in 0..=count {
            beside.position[2 * crank] = 1e-3;
            if crank < count {
                beside.position[2 * crank + 1] = -1e-3;
            }
        }
        assemble(&mechanism, &mut beside).unwrap();
    }
}

#[test]
fn a_linkage_that_begins_to_move_has_not_passed_a_singular_position() {
    for kept in [&[][..], &[Rule::Planar]] {
        let (mut mechanism, start) = closed::four_bars(1, 5);
        mechanism.gravity = Vector3::zeros();
        let mut state = State { velocity: vec![0.0; mechanism.velocity_count], ..start.clone() };
        let mut lobatto = Lobatto::fixed(&mechanism, 5, 0.01).unwrap().keeping(&mechanism, kept);
        // At rest nothing has to be projected, so that nothing is known of the loop.
        for _ in 0..3 {
            lobatto.advance(&mechanism, &mut state, f64::INFINITY).unwrap();
        }
        state.velocity.copy_from_slice(&start.velocity);
        for _ in 0..3 {
            lobatto.advance(&mechanism, &mut state, f64::INFINITY).unwrap();
        }
        assert_eq!(lobatto.description().singular, None, "without {kept:?}");
    }
}

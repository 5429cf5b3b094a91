//! The step is the same with the vectors of every processor. All of them are there with `--features every-processor` alone, as they are shipped.

use catena_kernels::{are_complete_for, step_for};
use catena_lobatto::numbers::lanes::Isa;
use catena_lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena_lobatto::tableau::butcher::Tableau;
use catena_mechanism as mechanism;
use mechanism::description::body_state::BodyState;
use mechanism::description::rules::Rule;
use mechanism::motion::kinematics::body_states;
use models::Model;

#[path = "../../../tests/shared/models/mod.rs"]
mod models;

/// Poses and velocities after one step with the vectors of a processor, iterated as `rule` says.
fn end(model: &Model, stages: usize, step: f64, isa: Isa, rule: StopRule) -> Vec<BodyState> {
    let mechanism = &model.mechanism;
    let tableau = Tableau::of(stages).expect("stages");
    let mut kernel = step_for(mechanism, tableau, isa, &[Rule::Planar]);
    kernel.expect(mechanism, rule.increment);
    let mut state = model.state.clone();
    kernel.begin(mechanism, &state);
    let attempt = kernel.attempt(mechanism, step, &rule, Guess::Plain);
    assert!(matches!(attempt, Attempt::Converged { .. }), "{}, {stages} stages: {attempt:?}", mechanism.name);
    kernel.finish(mechanism, &mut state);
    body_states(mechanism, &state)
}

#[test]
fn every_instruction_set_makes_the_same_step_to_rounding() {
    // Only roundings differ between steps with and without fused multiply-add; AVX2 and AVX-512 share every operation.
    let has_wide = are_complete_for(Isa::Avx2);
    if !has_wide {
        println!("skipped: AVX2 with more than four lanes; test with --features every-processor");
    }
    for model in models::every_model() {
        for stages in [2, 3, 4, 5, 7, 9, 12, 16] {
            let [portable, narrow, wide] =
                [Isa::Portable, Isa::Avx2, Isa::Avx512].map(|isa| end(&model, stages, 0.02, isa, StopRule::ROUNDING));
            let name = &model.mechanism.name;
            let difference = models::pose_distance(&portable, &wide);
            assert!(difference < 1e-13, "{name}, {stages} stages: portable differs by {difference:.1e}");
            // Four lanes hold five stages.
            assert!(narrow == wide || (stages > 5 && !has_wide), "{name}, {stages} stages: AVX2 and AVX-512 differ");
        }
    }
}

#[test]
fn steps_that_begin_in_single_precision_have_the_same_bits_with_avx2_and_avx_512() {
    if !are_complete_for(Isa::Avx2) {
        println!("skipped: AVX2 with more than four lanes is not compiled; test with --features every-processor");
        return;
    }
    for model in models::every_model() {
        for increment in [1e-3, 1e-7] {
            let rule = StopRule { increment, rough: true, ..StopRule::ROUNDING };
            let [narrow, wide] = [Isa::Avx2, Isa::Avx512].map(|isa| end(&model, 9, 0.05, isa, rule));
            assert!(narrow == wide, "{} to {increment:e}", model.mechanism.name);
        }
    }
}

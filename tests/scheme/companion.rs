//! The motion that is carried beside that of a run, held against its literal twin: the same steps, iterated to rounding.

use crate::models;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::StopRule;
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::distance::{distance, probes};
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::Lobatto;
use catena::stepping::step_maker::StepMaker;

const STEPS: usize = 30;

/// How far steps that are iterated to `increment` end from those that are iterated to rounding, how far from their companion, and how far that is from
/// the latter (m).
fn apart(mechanism: &Mechanism, start: &State, step: f64, increment: f64, isa: Isa) -> [f64; 3] {
    let rule = StopRule { increment, ..StopRule::ROUNDING };
    let mut coarse = Lobatto::fixed_with(mechanism, 5, step, rule, isa).unwrap();
    coarse.accompany(mechanism);
    let mut exact = Lobatto::fixed_with(mechanism, 5, step, StopRule::ROUNDING, isa).unwrap();
    let (mut here, mut there) = (start.clone(), start.clone());
    for _ in 0..STEPS {
        coarse.advance(mechanism, &mut here, f64::INFINITY).unwrap();
        exact.advance(mechanism, &mut there, f64::INFINITY).unwrap();
    }
    let companion = coarse.companion().expect("a companion").state();
    assert_eq!(companion.time, here.time);
    let [own, other, carried] = [&here, &there, companion].map(|state| probes(mechanism, state));
    [distance(&own, &other), distance(&own, &carried), distance(&carried, &other)]
}

#[test]
fn what_a_companion_says_of_the_errors_of_a_run_is_what_the_same_steps_say_that_are_iterated_to_rounding() {
    let tree = models::floating_tree();
    let mut cases = vec![
        ("in a plane", models::planar_chain(4), 0.02),
        ("in space", models::spatial_pendulum(), 0.02),
        ("a chain", models::chain(6), 0.02),
        ("on a floating base", models::floating_tree(), 0.02),
        ("on a ball joint", models::one_joint(JointKind::Spherical), 0.02),
        ("in free flight", models::free_body(), 0.02),
    ];
    for (_, forces) in models::every_force(&tree.mechanism) {
        cases.push(("under forces", models::with_forces(models::floating_tree(), forces), 0.01));
    }
    for (name, model, step) in cases {
        for isa in [Isa::Avx512, Isa::Avx2, Isa::Portable] {
            let [error, said, left] = apart(&model.mechanism, &model.state, step, 1e-6, isa);
            println!("{name}, {isa:?}: error {error:.2e} m, said {said:.2e} m, companion off by {left:.2e} m");
            // A step of the companion leaves a twentieth of what parts the motions, at most, in every step anew, and that is amplified.
            assert!(
                said <= 3.0 * error + 1e-13 && error <= 3.0 * said + 1e-13,
                "{name}, {isa:?}: {said:e} of {error:e} m"
            );
        }
    }
}

#[test]
fn a_companion_of_steps_that_leave_nothing_but_rounding_stays_within_rounding() {
    for model in [models::planar_chain(4), models::chain(6), models::floating_tree()] {
        let [_, said, _] = apart(&model.mechanism, &model.state, 0.01, 2e-16, Isa::detect());
        // Thirty steps of motions that hardly amplify errors.
        assert!(said < 1e-13, "{}: {said:e} m", model.mechanism.name);
    }
}

#[test]
fn the_steps_of_a_run_with_a_companion_have_the_bits_of_those_without() {
    for model in [models::planar_chain(4), models::chain(6), models::floating_tree()] {
        let ends = [false, true].map(|accompanied| {
            let mut lobatto = Lobatto::adaptive(&model.mechanism, 1e-6);
            if accompanied {
                lobatto.accompany(&model.mechanism);
            }
            let mut state = model.state.clone();
            for _ in 0..STEPS {
                lobatto.advance(&model.mechanism, &mut state, f64::INFINITY).unwrap();
            }
            let (mut position, mut velocity) = (state.position.clone(), state.velocity.clone());
            lobatto.dense(&model.mechanism, state.time - 1e-3, &mut position, &mut velocity);
            (state, position, velocity)
        });
        assert_eq!(ends[0], ends[1], "{}", model.mechanism.name);
    }
}

#[test]
fn a_companion_is_left_where_somebody_moves_the_state() {
    let model = models::chain(3);
    let mut lobatto = Lobatto::adaptive(&model.mechanism, 1e-6);
    lobatto.accompany(&model.mechanism);
    let mut state = model.state.clone();
    lobatto.advance(&model.mechanism, &mut state, f64::INFINITY).unwrap();
    assert!(lobatto.companion().is_some());
    state.velocity[0] += 0.1;
    lobatto.advance(&model.mechanism, &mut state, f64::INFINITY).unwrap();
    assert!(lobatto.companion().is_none(), "its errors are not those of this motion");
}

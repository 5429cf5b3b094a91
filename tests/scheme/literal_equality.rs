//! The fast kernel makes the same step as the literal scheme (2.5.11), with forces and without.

use crate::literal::scheme::Literal;
use crate::models::{self, Model};
use catena::kernels::step_for;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::kinematics::body_states;

/// Poses and velocities after one step of the fast kernel in space; `tests/scheme/planar/trees.rs` has that in a plane.
fn fast_step(model: &Model, stages: usize, step: f64) -> Vec<catena::mechanism::description::body_state::BodyState> {
    let tableau = Tableau::of(stages).unwrap();
    let mut kernel = step_for(&model.mechanism, tableau, Isa::detect(), &[Rule::Planar]);
    let mut state = model.state.clone();
    kernel.begin(&model.mechanism, &state);
    let attempt = kernel.attempt(&model.mechanism, step, &StopRule::ROUNDING, Guess::Plain);
    assert!(matches!(attempt, Attempt::Converged { .. }), "{} s={stages}: {attempt:?}", model.mechanism.name);
    kernel.finish(&model.mechanism, &mut state);
    body_states(&model.mechanism, &state)
}

/// Both solvers stop at rounding; the literal one works on entries of size one to ten with dense LU factors, whose
/// condition (at most some 1e3 here) times 1e-16 is well below the bounds.
fn assert_literal(model: &Model, forces: &str, stages: usize) {
    let step = 0.02;
    let literal = Literal::new(&model.mechanism, Tableau::of(stages).unwrap()).unwrap();
    let literal = literal.step(&model.bodies(), step).unwrap().bodies;
    let fast = fast_step(model, stages, step);
    let position = models::pose_distance(&fast, &literal);
    let velocity = models::velocity_distance(&fast, &literal);
    let name = &model.mechanism.name;
    println!("{name}, {forces}, s={stages}: {position:.1e} {velocity:.1e}");
    assert!(position < 1e-12, "{name}, {forces}, s={stages}: poses differ by {position:.1e}");
    assert!(velocity < 1e-11, "{name}, {forces}, s={stages}: velocities differ by {velocity:.1e}");
}

#[test]
fn one_step_equals_the_literal_scheme_for_every_joint_kind_and_two_to_five_stages() {
    for model in models::every_model() {
        for stages in 2..=5 {
            assert_literal(&model, "no forces", stages);
        }
    }
}

#[test]
fn one_step_equals_the_literal_scheme_for_every_force_every_joint_kind_and_two_to_five_stages() {
    // The bounds as without forces: forces of some ten newtons on bodies of a kilogram are no larger than gravity.
    let mut models: Vec<Model> = models::JOINT_KINDS.into_iter().map(models::one_joint).collect();
    models.push(models::floating_tree());
    for model in models {
        for (kind, forces) in models::every_force(&model.mechanism) {
            let model =
                models::with_forces(Model { mechanism: model.mechanism.clone(), state: model.state.clone() }, forces);
            for stages in 2..=5 {
                // The dense oracle takes its time for five bodies.
                if model.mechanism.bodies.len() > 2 && (kind != "all forces" || stages > 3) {
                    continue;
                }
                assert_literal(&model, kind, stages);
            }
        }
    }
}

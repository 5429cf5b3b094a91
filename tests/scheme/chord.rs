//! Iterations that keep the factors of an earlier one have the residual of their own iterate, and end where the others do.

use crate::models::{self, Model};
use catena::lobatto::numbers::lanes::Lanes;
use catena::lobatto::solve::kept_factors::Chord;
use catena::lobatto::stages::workspace::Stages;
use catena::lobatto::tableau::butcher::Tableau;
use catena::lobatto::vectors::portable::Portable;

/// The fewest lanes with an inner stage: `iterate` has all sweeps written out in place, and they are compiled for this type alone.
type Two = Portable<2>;

/// All models, and all forces on one of them.
fn models_and_forces() -> Vec<Model> {
    let mut all = models::every_model();
    let tree = models::floating_tree();
    let forces = models::every_force(&tree.mechanism);
    all.extend(forces.into_iter().map(|(_, forces)| {
        let tree = Model { mechanism: tree.mechanism.clone(), state: tree.state.clone() };
        models::with_forces(tree, forces)
    }));
    all
}

/// The stages of a step of 20 ms from the state of a model, guessed to stay where they are.
fn stages_of(model: &Model) -> Stages<Two> {
    let mut stages = Stages::new(&model.mechanism, Tableau::of(3).unwrap(), &[]);
    stages.start.set(&model.mechanism, &model.state);
    stages.step = 0.02;
    stages
}

/// The increments of an iteration from the displacements at hand, with new factors or with those of the last one.
fn iterate(stages: &mut Stages<Two>, model: &Model, keep: bool) -> Vec<f64> {
    let gravity = model.mechanism.gravity.into();
    stages.sweep_poses();
    if stages.applied.is_some() {
        stages.sweep_applied(false);
    }
    match (stages.applied.is_some(), keep) {
        (true, true) => stages.sweep_forced_wrenches(&gravity),
        (true, false) => stages.sweep_forced_residual(&gravity),
        (false, true) => stages.sweep_wrenches::<true>(&gravity),
        (false, false) => stages.sweep_residual(&gravity),
    }
    stages.sweep_increments();
    stages.increment.iter().flat_map(|lanes| lanes.to_array()).collect()
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |largest, value| value.abs().max(largest))
}

#[test]
fn with_the_factors_of_the_same_iterate_an_iteration_is_the_full_one() {
    for model in models_and_forces() {
        let mut stages = stages_of(&model);
        // Away from the start, so that every body has turned and every arm has moved.
        for _ in 0..2 {
            iterate(&mut stages, &model, false);
            stages.advance();
        }
        let full = iterate(&mut stages, &model, false);
        let kept = iterate(&mut stages, &model, true);
        let apart = largest(full.iter().zip(&kept).map(|(a, b)| a - b));
        // The same numbers but for the order of sums, and the second half of the coefficients' digits where there are no
        // forces: roundings of displacements below one, which light bodies on heavy ones magnify by some 1e3.
        assert!(apart < 1e-12, "{}: {apart:.1e}", model.mechanism.name);
    }
}

#[test]
fn with_the_factors_of_another_iterate_a_solution_is_a_solution_still() {
    for model in models_and_forces() {
        let mut stages = stages_of(&model);
        let first = largest(iterate(&mut stages, &model, false));
        for _ in 0..30 {
            stages.advance();
            iterate(&mut stages, &model, false);
        }
        let solution = stages.displacement.clone();
        stages.displacement.fill(Two::splat(0.3));
        let elsewhere = largest(iterate(&mut stages, &model, false));
        stages.displacement = solution;
        let left = largest(iterate(&mut stages, &model, true));
        // Roundings again; what factors and residuals of one geometry would leave is of the size of the first increments.
        assert!(first > 1e-5 && elsewhere > 1e-3, "{}: {first:.1e}, {elsewhere:.1e}", model.mechanism.name);
        assert!(left < 1e-12, "{}: {left:.1e}", model.mechanism.name);
    }
}

#[test]
fn factors_are_kept_once_increments_are_small_and_later_where_that_was_a_loss() {
    let mut chord = Chord::NEW;
    // Whether the second iteration of a step keeps factors after a first increment, and what the second increment is then.
    let mut step = |first: f64, second: f64| {
        chord.restart();
        assert!(!chord.keeps(), "a step begins without factors");
        chord.see(first);
        let keeps = chord.keeps();
        chord.see(second);
        (keeps, chord.keeps())
    };
    assert_eq!(step(0.5, 0.05), (false, true));
    assert_eq!(step(0.05, 0.005), (true, true));
    // An increment that hardly falls: new factors for the rest of the step, and kept a decade later from then on.
    assert_eq!(step(0.05, 0.04), (true, false));
    assert_eq!(step(0.05, 0.005), (false, true));
    // A little sooner again in every step.
    for _ in 0..20 {
        step(1.0, 1.0);
    }
    assert_eq!(step(0.05, 0.005), (true, true));
    // Roundings say nothing.
    assert_eq!(step(1e-13, 1e-13), (true, true));
}

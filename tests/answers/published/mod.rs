//! Published benchmark problems, with their published or independently computed answers.
//!
//! The numbers are those of the project's page of benchmark problems (`benchmarks.md`); the comments on the
//! tables name the sections there, and the sources that page gives for them. Computed answers hold to all digits printed.

mod pendula;
mod tops;

use crate::common::run_until;
use crate::models::Model;
use catena::kinematics::body_states;
use catena::lobatto::Lobatto;
use catena::simulation::Summary;
use catena::state::BodyState;

/// Visits the bodies at each of the `times` of a run by steps of nine stages; returns the figures of the worst stretch.
fn visit(model: &Model, step: f64, times: &[f64], mut look: impl FnMut(usize, &[BodyState])) -> Summary {
    let mut state = model.state.clone();
    let mut lobatto = Lobatto::fixed(&model.mechanism, 9, step).unwrap();
    let mut worst = Summary::default();
    for (index, &time) in times.iter().enumerate() {
        let summary = run_until(&model.mechanism, &mut state, &mut lobatto, time);
        worst.max_relative_energy_error = worst.max_relative_energy_error.max(summary.max_relative_energy_error);
        worst.rejected_steps += summary.rejected_steps;
        look(index, &body_states(&model.mechanism, &state));
    }
    worst
}

fn assert_close(found: f64, expected: f64, bound: f64, what: &str) {
    let error = (found - expected).abs();
    println!("{what}: {error:.1e}");
    assert!(error <= bound, "{what}: {found} instead of {expected}, off by {error:.1e}");
}

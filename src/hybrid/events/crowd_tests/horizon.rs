//! Steps over events beyond the horizon of a run.

use super::boxes;
use crate::events::integrator::Eventful;
use crate::stepping::length::stage_choice::StageChoice;
use crate::stepping::recipe::{Recipe, Steps};
use nalgebra::Vector3;

#[test]
fn no_step_beyond_the_horizon_is_made_shorter_for_the_tolerance_in_this_run_and_those_that_go_on_from_it() {
    let mechanism = boxes(2, Vector3::repeat(0.1), 0.5, 0.0);
    let steps = Steps::Chosen { tolerance: 1e-3, stop: 1e-5, stages: StageChoice::Many };
    let new = || Eventful::new(&mechanism, Recipe::new(steps, Vec::new())).expect("possible steps");
    let mut first = new();
    // Two boxes of 1 kg with 6 m/s: h = 1e-3/(0.3 · 6).
    first.memory.kinetic = 36.0;
    let (length, keeps) = first.crowd_length();
    assert!(keeps && (length - 1e-3 / 1.8).abs() < 1e-9, "{length}");
    first.pass_horizon();
    assert_eq!(first.crowd_length(), (1e-3, true));
    let mut second = new();
    second.go_on_from(new().crowds_so_far().with(first.crowds_so_far()));
    assert_eq!(second.crowd_length().0, 1e-3);
    // Slow motions keep their longer steps.
    second.memory.kinetic = 1.0;
    assert!(second.crowd_length().0 > 1e-3);
}

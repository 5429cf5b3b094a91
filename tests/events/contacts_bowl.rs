//! A ball on the facets of a mesh: what leaves a facet slowly, while another one carries it, does leave it.

use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::{Simulation, SimulationOptions, StepChoice};
use std::path::Path;

/// Where the ball of `robots/ball_in_bowl.toml` is after 1.2 s, and how many steps that took.
fn rolls(tolerance: f64) -> (State, usize) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/ball_in_bowl.toml");
    let scene = read_scene(&file, &PackagePath::default()).expect("a scene");
    let (model, start) = Model::from_scene(&scene).expect("a model");
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    let steps = StepChoice::Tolerance(tolerance);
    let options = SimulationOptions::new(1.2, steps);
    let mut simulation = Simulation::new(&model.mechanism, start, options).expect("a run");
    simulation.run().expect("to the end");
    let finished = simulation.finish();
    (finished.state, finished.summary.steps)
}

#[test]
fn a_ball_in_a_faceted_bowl_ends_at_the_same_place_whatever_the_tolerance() {
    let (wanted, _) = rolls(1e-8);
    for tolerance in [1e-2, 1e-3, 1e-6] {
        let (found, steps) = rolls(tolerance);
        let apart = found.position[..3].iter().zip(&wanted.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{tolerance:e}: {steps} steps, {apart:e} m apart");
        // At t = 0.412 s it rolls from one facet to the next, which opens the first at 3.6e-4 m/s. Where that was taken for rest, it ended 6e-3 m off.
        assert!(apart <= tolerance, "{tolerance:e}: {apart:e} m");
    }
}

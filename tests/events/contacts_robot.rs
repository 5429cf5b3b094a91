//! A robot that is dropped and stands on its legs, held by its motors.

use catena::mechanism::motion::contact_point::ContactPoint;
use catena::mechanism::motion::event::{Event, EventKind};
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::{Simulation, SimulationOptions, StepChoice};
use std::path::Path;

/// The contacts that are closed at some instants, and the state at the last of them.
fn stands(name: &str, times: &[f64]) -> (Vec<Vec<ContactPoint>>, State) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(format!("{name}.toml"));
    let scene = read_scene(&file, &PackagePath::default()).expect("a scene");
    let (model, start) = Model::from_scene(&scene).expect("a model");
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    let duration = times.iter().fold(0.0, |most: f64, &time| most.max(time));
    let options = SimulationOptions::new(duration, StepChoice::Tolerance(1e-6));
    let mut simulation = Simulation::new(&model.mechanism, start, options).expect("a run");
    let points = times
        .iter()
        .map(|&time| {
            simulation.step_to(time).expect("steps");
            simulation.contacts()
        })
        .collect();
    let finished = simulation.finish();
    let summary = &finished.summary;
    println!("{name}: {} steps, {} events, {summary:?}", summary.steps, summary.events.total());
    assert!(summary.contact.penetration <= 1e-12, "{:?}", summary.contact);
    // Forces of some hundred newtons.
    assert!(summary.contact.cone_violation <= 1e-8, "{:?}", summary.contact);
    (points, finished.state)
}

#[test]
fn a_quadruped_that_is_dropped_stands_on_four_feet_that_do_not_creep() {
    let (points, state) = stands("quadruped_dropped", &[10.0, 100.0]);
    for instant in &points {
        assert_eq!(instant.len(), 4, "{instant:?}");
        assert!(instant.iter().all(|point| point.sticks), "{instant:?}");
    }
    for (before, after) in points[0].iter().zip(&points[1]) {
        let creep = (before.position - after.position).norm();
        println!("creep {creep:e} m in 90 s");
        assert!(creep <= 1e-12, "{creep:e} m");
    }
    println!("{:?}", state.velocity);
}

#[test]
fn motors_that_an_impact_throws_beyond_their_bounds_are_there_at_once_whatever_the_step() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/quadruped_dropped.toml");
    let scene = read_scene(&file, &PackagePath::default()).expect("a scene");
    let (model, start) = Model::from_scene(&scene).expect("a model");
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    let run = |steps: StepChoice| {
        let options = SimulationOptions::new(0.2, steps);
        let mut simulation = Simulation::new(&model.mechanism, start.clone(), options).expect("a run");
        simulation.run().expect("to the end");
        simulation.finish()
    };
    let fine = run(StepChoice::Fixed { stages: 9, step: 1e-3 });
    // The feet land after 0.101 s; the knees are at their bounds for 1 to 2 ms from then on, within steps of up to 0.1 s.
    for tolerance in [1e-3, 1e-5, 1e-7] {
        let found = run(StepChoice::Tolerance(tolerance));
        let at_once = |event: &&Event| event.kind == EventKind::Saturation;
        let times: Vec<f64> = found.events.iter().filter(at_once).map(|event| event.time).collect();
        let impact = found.events.iter().find(|event| event.kind == EventKind::ContactImpact).expect("they land").time;
        assert!(times.len() == 4 && times.iter().all(|&time| time == impact), "{tolerance:e}: {times:?}, {impact}");
        for (one, other) in found.state.position.iter().zip(&fine.state.position) {
            // Far better than the tolerance; without the bounds it is 1e-4.
            assert!((one - other).abs() <= 1e-9, "{tolerance:e}: {one}, {other}");
        }
    }
}

//! A ball on the facets of a mesh: what leaves a facet slowly, while another one carries it, does leave it.

use crate::loose::{DOWN, loose, meet, obstacle, resting};
use crate::mechanisms::run;
use catena::mechanism::description::contact::{Shape, Surface};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::{Simulation, SimulationOptions, StepChoice};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::Path;
use std::sync::Arc;

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

/// Half a ball about the origin (m), open upwards: rings of facets of two triangles each, seen from inside.
fn hollow(radius: f64, rings: u32, facets: u32) -> Shape {
    let place = |ring: u32, facet: u32| {
        let (down, round) =
            (FRAC_PI_2 * f64::from(ring) / f64::from(rings), TAU * f64::from(facet) / f64::from(facets));
        Vector3::new(down.sin() * round.cos(), down.sin() * round.sin(), -down.cos()) * radius
    };
    let rest = (1..=rings).flat_map(|ring| (0..facets).map(move |facet| place(ring, facet)));
    let vertices = std::iter::once(place(0, 0)).chain(rest).collect();
    let number = |ring: u32, facet: u32| 1 + (ring - 1) * facets + facet % facets;
    let bottom = (0..facets).map(|facet| [0, number(1, facet), number(1, facet + 1)]);
    let sides = (1..rings).flat_map(|ring| (0..facets).map(move |facet| (ring, facet))).flat_map(|(ring, facet)| {
        let [a, b] = [facet, facet + 1].map(|facet| number(ring, facet));
        let [c, d] = [facet + 1, facet].map(|facet| number(ring + 1, facet));
        [[a, d, c], [a, c, b]]
    });
    Shape::Mesh(Arc::new(Surface { vertices, triangles: bottom.chain(sides).collect() }))
}

#[test]
fn a_ball_among_many_small_triangles_has_certified_steps_and_one_motion() {
    let gap = |at: &[f64]| 0.4 - at.iter().map(|x| x * x).sum::<f64>().sqrt() - 0.05;
    for offset in [0.0, 0.02] {
        let mut mechanism = loose(DOWN, &[(0.5, Shape::Sphere { radius: 0.05 })]);
        // A ball that is heavy on one side comes nearer by its turns alone.
        mechanism.nonsmooth.colliders[0].pose = Pose::translation(offset, 0.0, 0.0);
        let bowl = obstacle(&mut mechanism, hollow(0.4, 16, 36), Vector3::zeros());
        meet(&mut mechanism, bowl, 0, 0.3, 0.0);
        let start = resting(&mechanism, &[Vector3::new(0.2, 0.03, -0.25)]);
        let [fine, coarse] =
            [1e-8, 1e-5].map(|tolerance| run(&mechanism, &start, 0.7, StepChoice::Tolerance(tolerance)));
        let apart = |place: usize| (fine.state.position[place] - coarse.state.position[place]).abs();
        assert!((0..3).all(|place| apart(place) <= 1e-5), "{offset}: {:?} {:?}", fine.state, coarse.state);
        assert!(fine.summary.contact.penetration <= 1e-9, "{offset}: {:?}", fine.summary.contact);
        // Facets are nearer than the sphere through their corners by less than 2 mm.
        let above = gap(&fine.state.position[..3]);
        assert!(offset > 0.0 || (-1e-9..2e-3).contains(&above), "{offset}: {above:e}");
        assert!(
            fine.summary.max_relative_energy_error < 1e-7,
            "{offset}: {:e}",
            fine.summary.max_relative_energy_error
        );
    }
}

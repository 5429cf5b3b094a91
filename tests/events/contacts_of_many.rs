//! Many bodies: the pairs that a run does not look at are proved apart, and leave no trace in its results.

use crate::common::Numbers;
use crate::loose::{DOWN, loose, meet, obstacle, put};
use crate::mechanisms::{fixed, run};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::Vector3;

/// Balls with a floor that may all touch: more than a thousand pairs, of which those far apart are left out. With `all` every pair is looked at, because
/// the last one, of a ball with the floor, is in no order.
fn balls(gravity: Vector3<f64>, radii: &[f64], restitution: f64, all: bool) -> Mechanism {
    let shapes: Vec<(f64, Shape)> = radii.iter().map(|&radius| (1.0, Shape::Sphere { radius })).collect();
    let mut mechanism = loose(gravity, &shapes);
    let count = shapes.len();
    let floor = obstacle(&mut mechanism, Shape::HalfSpace, Vector3::zeros());
    for first in 0..count {
        (first + 1..count).for_each(|second| meet(&mut mechanism, first, second, 0.5, restitution));
        let (a, b) = if all && first + 1 == count { (floor, first) } else { (first, floor) };
        meet(&mut mechanism, a, b, 0.5, restitution);
    }
    mechanism
}

#[test]
fn a_bullet_meets_the_ball_in_its_way_however_long_the_steps_are_and_however_far_the_ball_was() {
    // Forty-nine balls of 0.1 m on a grid of 1 m, and one of 5 mm that flies between them, 50 m to the last one, at 400 m/s.
    let radii: Vec<f64> = (0..50).map(|ball| if ball == 0 { 0.005 } else { 0.1 }).collect();
    let mechanism = balls(Vector3::zeros(), &radii, 1.0, false);
    let none = Vector3::zeros();
    for steps in [fixed(9, 0.2), StepChoice::Tolerance(1e-6)] {
        let mut start = State::zero(&mechanism);
        for ball in 1..50 {
            let at = if ball == 49 {
                Vector3::new(40.0, 0.5, 3.0)
            } else {
                Vector3::new((ball % 7) as f64, (ball / 7) as f64, 3.0)
            };
            put(&mechanism, &mut start, ball, [at, none, none, none]);
        }
        put(&mechanism, &mut start, 0, [Vector3::new(-10.0, 0.5, 3.0), none, Vector3::x() * 400.0, none]);
        let finished = run(&mechanism, &start, 0.2, steps);
        let hits: Vec<f64> = finished
            .events
            .iter()
            .filter(|event| event.kind == EventKind::ContactImpact)
            .map(|event| event.time)
            .collect();
        // 50 m less both radii; the masses are the same, so that the bullet stops. Coordinates are rounded to 7e-15 m.
        let met = (50.0 - 0.105) / 400.0;
        assert!(hits.len() == 1 && (hits[0] - met).abs() <= 1e-14, "{hits:?}, not {met}");
        let places = mechanism.bodies[49].joint.position_range();
        let moved = finished.state.position[places.start] - 40.0;
        assert!((moved - 400.0 * (0.2 - met)).abs() <= 1e-11, "{moved}");
        assert!((finished.state.position[0] - (40.0 - 0.105)).abs() <= 1e-11);
    }
}

#[test]
fn a_run_that_leaves_pairs_out_is_the_same_to_the_last_bit_as_one_that_looks_at_all() {
    for (layers, count, restitution, duration) in [(1, 26, 0.6, 0.06), (3, 13, 0.0, 0.1)] {
        let ends: Vec<State> = [false, true]
            .map(|all| {
                let mechanism = balls(DOWN, &vec![0.1; count], restitution, all);
                let (mut start, mut numbers) = (State::zero(&mechanism), Numbers::new(5));
                let mut any = |most: f64| Vector3::from([(); 3].map(|()| numbers.next(-most, most)));
                for ball in 0..count {
                    let side = if layers == 1 { 6 } else { 2 };
                    let (x, y, z) = (ball % side, ball / side % side, ball / (side * side));
                    let spread = if layers == 1 { 0.35 } else { 0.22 };
                    let at = Vector3::new(spread * x as f64, spread * y as f64, 0.15 + 0.22 * z as f64);
                    let at = if ball + 1 == count { Vector3::new(0.0, 0.0, 30.0) } else { at + any(0.01) };
                    let thrown = if layers == 1 { any(1.0) } else { any(0.1) };
                    put(&mechanism, &mut start, ball, [at, Vector3::zeros(), thrown, Vector3::zeros()]);
                }
                let finished = run(&mechanism, &start, duration, StepChoice::Tolerance(1e-3));
                println!("{layers}: {} steps, {} events", finished.summary.steps, finished.events.len());
                finished.state
            })
            .into();
        assert_eq!(ends[0], ends[1], "{layers} layers");
    }
}

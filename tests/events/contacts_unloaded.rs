//! Balls that touch each other without a force: a rack on a floor, and balls that have stopped each other where there is no gravity.

use crate::loose::{DOWN, loose, meet, obstacle, put, resting};
use crate::mechanisms::{of_kind, run};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::Vector3;
use std::f64::consts::TAU;

const RADIUS: f64 = 0.0286;

/// Balls in rows of one, two, three and so on, that touch each other and rub on each other and on the floor.
fn rack(masses: &[f64], rubs: f64, on_floor: f64) -> (Mechanism, State) {
    let balls: Vec<(f64, Shape)> = masses.iter().map(|&mass| (mass, Shape::Sphere { radius: RADIUS })).collect();
    let mut rack = loose(DOWN, &balls);
    let floor = obstacle(&mut rack, Shape::HalfSpace, Vector3::zeros());
    for first in 0..balls.len() {
        meet(&mut rack, floor, first, on_floor, 0.0);
        (first + 1..balls.len()).for_each(|second| meet(&mut rack, first, second, rubs, 0.9));
    }
    let places = (0_usize..).flat_map(|row| (0..=row).map(move |place| (row as f64, place as f64)));
    let places =
        places.map(|(row, place)| Vector3::new(3.0_f64.sqrt() * RADIUS * row, RADIUS * (2.0 * place - row), RADIUS));
    let places: Vec<Vector3<f64>> = places.take(balls.len()).collect();
    let start = resting(&rack, &places);
    (rack, start)
}

#[test]
fn a_rack_of_balls_that_rub_on_each_other_stands_without_a_step_that_is_rejected() {
    // The floor bears each ball, and nothing is left for the contacts between them: none of their forces can be anything else than zero.
    let mut uneven = [0.17; 10];
    (uneven[0], uneven[4], uneven[8]) = (0.4, 0.05, 0.3);
    for (masses, rubs, on_floor) in [(&[0.17; 10], 0.2, 0.39), (&[0.17; 10], 0.06, 0.2), (&uneven, 0.2, 0.39)] {
        let (rack, start) = rack(masses, rubs, on_floor);
        let finished = run(&rack, &start, 0.02, StepChoice::Tolerance(1e-6));
        let (summary, method) = (&finished.summary, &finished.method);
        println!(
            "{rubs}, {on_floor}: {} steps, {:?}, {} events",
            summary.steps,
            summary.cost.rejected,
            finished.events.len()
        );
        // 29 rejected steps, and one of first order.
        assert_eq!((summary.cost.rejected.total(), method.first_order_steps, method.unsolved_contacts), (0, 0, 0));
        assert!(finished.events.is_empty() && summary.steps <= 5, "{} steps, {:?}", summary.steps, finished.events);
        assert_eq!(finished.state.position, start.position);
    }
}

/// Balls that come from all sides at the same time, and meet another one in the middle.
fn from_all_sides(count: usize, radius: f64, friction: f64) -> (Mechanism, State) {
    let mut balls = vec![(1.0, Shape::Sphere { radius: 0.1 })];
    balls.extend(vec![(0.3, Shape::Sphere { radius }); count]);
    let mut scene = loose(Vector3::zeros(), &balls);
    for first in 0..=count {
        (first + 1..=count).for_each(|second| meet(&mut scene, first, second, friction, 0.0));
    }
    let mut start = resting(&scene, &vec![Vector3::zeros(); count + 1]);
    for number in 0..count {
        let (y, x) = (TAU * number as f64 / count as f64).sin_cos();
        let (outwards, none) = (Vector3::new(x, y, 0.0), Vector3::zeros());
        put(&scene, &mut start, number + 1, [outwards * 0.5, none, outwards * -1.3, none]);
    }
    (scene, start)
}

#[test]
fn balls_that_have_stopped_each_other_where_nothing_pulls_at_them_bear_no_force_and_no_contact_is_released() {
    // They meet the one in the middle before they meet each other.
    for (count, radius, friction) in [(8, 0.05, 0.0), (8, 0.05, 0.5), (9, 0.04, 0.5), (10, 0.04, 0.5), (12, 0.03, 0.5)]
    {
        let (scene, start) = from_all_sides(count, radius, friction);
        let finished = run(&scene, &start, 1.0, StepChoice::Tolerance(1e-6));
        let (summary, method) = (&finished.summary, &finished.method);
        let released = of_kind(&finished, EventKind::Release).len();
        println!("{count}, {friction}: {} steps, {released} released, {:?}", summary.steps, summary.contact);
        // Rates of 1e-14 rad/s gave forces of 1e-29 N: 24 releases, the law of contact unsolved at 13 instants, and 360 steps over slips.
        assert_eq!((released, method.unsolved_contacts, method.first_order_steps), (0, 0, 0), "{count}, {friction}");
        assert_eq!((summary.cost.rejected.total(), summary.contact.cone_violation), (0, 0.0), "{count}, {friction}");
        assert_eq!(finished.contacts.len(), count);
        assert!(finished.state.velocity.iter().all(|rate| *rate == 0.0), "{:?}", finished.state.velocity);
    }
}

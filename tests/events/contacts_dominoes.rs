//! A row of dominoes: each leans on the next one with two corners that are on the borders of its face, slides, and stops on the floor.

use crate::loose::{DOWN, cuboid, loose, on_floor, put};
use crate::mechanisms::run_within;
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::Vector3;

/// Half of a domino (m).
const HALF: [f64; 3] = [0.01, 0.05, 0.1];

#[test]
fn dominoes_that_lean_on_each_other_take_few_steps_and_hardly_one_of_first_order() {
    let [x, y, z] = HALF;
    let mut mechanism = loose(DOWN, &vec![(0.1, cuboid(x, y, z)); 8]);
    on_floor(&mut mechanism, 0.5, 0.0);
    let mut start = State::zero(&mechanism);
    for body in 0..8 {
        // The first one is pushed over its lower edge.
        let pushed = if body == 0 { 1.5 } else { 0.0 };
        let at = Vector3::new(0.08 * body as f64, 0.0, z);
        put(&mechanism, &mut start, body, [at, Vector3::zeros(), Vector3::x() * (pushed * z), Vector3::y() * pushed]);
    }
    // Four of them lean on the fifth at the end.
    let finished = run_within(600, &mechanism, &start, 0.65, StepChoice::Tolerance(1e-6));
    let (summary, method) = (&finished.summary, &finished.method);
    println!("{} steps, {} events, {:?}", summary.steps, summary.events.total(), summary.contact);
    // Rebounds that end follow each other in one instant or two.
    assert!(method.first_order_steps <= 1, "{}", method.first_order_steps);
    assert!(summary.steps <= 150, "{}", summary.steps);
    assert!(summary.contact.penetration <= 1e-12 && summary.contact.cone_violation <= 1e-10, "{:?}", summary.contact);
    // Iterations stop at 1e-9 m, along which the weights of all dominoes work.
    let bound = 1e-9 * 8.0 * 0.1 * 9.81 / summary.largest_kinetic;
    assert!(summary.max_relative_energy_error <= bound, "{:e} {bound:e}", summary.max_relative_energy_error);
}

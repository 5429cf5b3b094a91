//! Bodies that touch and fall freely beside each other: nothing presses on anything, and roundings of what does not decide nothing.

use crate::loose::{DOWN, cuboid, loose, meet, put};
use crate::mechanisms::{fixed, run_within};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::Vector3;

/// A box, a cylinder and a box on top of each other, off centre and turned about the vertical, with numbers that are not round, in free fall at 1.3 m/s.
fn falling(friction: f64, restitution: f64) -> (Mechanism, State) {
    let heights = [0.052, 0.118, 0.0713];
    let shapes = [
        (4.95, cuboid(0.1695, 0.1405, heights[0])),
        (3.35, Shape::Cylinder { radius: 0.095, half: heights[1] }),
        (0.74, cuboid(0.11, 0.087, heights[2])),
    ];
    let mut mechanism = loose(DOWN, &shapes);
    (0..2).for_each(|body| meet(&mut mechanism, body, body + 1, friction, restitution));
    let mut start = State::zero(&mechanism);
    let mut base = 0.4;
    for (body, height) in heights.into_iter().enumerate() {
        let side = 0.013 * body as f64;
        let at = Vector3::new(0.031 - side, 0.017 + side, base + height);
        base += 2.0 * height;
        let turned = Vector3::new(0.0, 0.0, 0.7 + 1.1 * body as f64);
        put(&mechanism, &mut start, body, [at, turned, Vector3::new(0.3, -0.2, -1.3), Vector3::zeros()]);
    }
    (mechanism, start)
}

#[test]
fn a_stack_in_free_fall_stays_together_in_few_steps_without_events() {
    for (friction, restitution) in [(0.8, 0.0), (0.5, 0.6), (0.0, 0.3)] {
        let (mechanism, start) = falling(friction, restitution);
        // Given steps first: nobody counts the steps of the run beside one with a tolerance.
        for steps in [fixed(9, 0.05), StepChoice::Tolerance(1e-6), StepChoice::Tolerance(1e-4)] {
            let finished = run_within(500, &mechanism, &start, 0.5, steps);
            let summary = &finished.summary;
            println!("{friction}, {steps:?}: {} steps, {} rejected", summary.steps, summary.cost.rejected.total());
            assert!(finished.events.is_empty(), "{:?}", finished.events);
            // Parabolas: a step may be as long as the run; the first is short where steps are chosen.
            assert!(summary.steps <= 30 && summary.cost.rejected.total() <= 4, "{friction}, {steps:?}: {summary:?}");
            assert_eq!(summary.contact.cone_violation, 0.0);
            // Each body falls as it would alone: 0.5 s of gravity and 1.3 m/s, to the roundings of a height of a metre.
            for (now, before) in finished.state.position.iter().zip(&start.position).skip(2).step_by(7) {
                let fallen = before - now - (1.3 * 0.5 + 0.5 * 9.81 * 0.25);
                assert!(fallen.abs() <= 1e-14, "{friction}, {steps:?}: {fallen:e}");
            }
        }
    }
}

#[test]
fn bodies_that_slip_and_turn_on_each_other_in_free_fall_do_so_in_few_steps() {
    // The same stack; each body turns about the vertical and slips on the one below, along planes that gravity is square to. Friction has nothing to act with.
    let spins = [0.4, -1.1, 2.3];
    for (friction, restitution) in [(0.5, 0.6), (0.8, 0.0)] {
        let (mechanism, mut start) = falling(friction, restitution);
        for (body, spin) in spins.into_iter().enumerate() {
            let freedoms = mechanism.bodies[body].joint.velocity_range();
            let velocity = &mut start.velocity[freedoms];
            velocity[0] += 0.11 * body as f64;
            velocity[5] = spin;
        }
        for steps in [StepChoice::Tolerance(1e-6), StepChoice::Tolerance(1e-4), fixed(5, 0.01)] {
            let finished = run_within(1000, &mechanism, &start, 0.1, steps);
            let summary = &finished.summary;
            println!("{friction}, {steps:?}: {} steps, {:?}", summary.steps, finished.events);
            assert!(summary.steps <= 60, "{friction}, {steps:?}: {} steps", summary.steps);
            let events: Vec<EventKind> = finished.events.iter().map(|event| event.kind).collect();
            assert!(!events.contains(&EventKind::ContactImpact), "{events:?}");
            let fall = 1.3 * 0.1 + 0.5 * 9.81 * 0.01;
            for body in 0..spins.len() {
                let freedoms = mechanism.bodies[body].joint.velocity_range();
                let place = mechanism.bodies[body].joint.position_range().start;
                let fallen = start.position[place + 2] - finished.state.position[place + 2] - fall;
                // What presses with 1e-9 of the weight counts as nothing and stays closed: 5e-11 m in 0.1 s, and more where bodies are light.
                assert!(fallen.abs() <= 1e-9, "{friction}, {steps:?}, body {body}: {fallen:e} m");
                for freedom in [0, 1, 5].map(|freedom| freedoms.start + freedom) {
                    let off = finished.state.velocity[freedom] - start.velocity[freedom];
                    assert!(off.abs() <= 1e-8, "{friction}, {steps:?}, body {body}: {off:e}");
                }
            }
        }
    }
}

//! Bodies that touch and fall freely beside each other: nothing presses on anything, and roundings of what does not decide nothing.

use crate::loose::{DOWN, cuboid, loose, meet, put};
use crate::mechanisms::{fixed, run};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::mechanism::Mechanism;
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
        for steps in [StepChoice::Tolerance(1e-6), StepChoice::Tolerance(1e-4), fixed(9, 0.05)] {
            let finished = run(&mechanism, &start, 0.5, steps);
            let summary = &finished.summary;
            println!("{friction}, {steps:?}: {} steps, {} rejected", summary.steps, summary.rejected_steps);
            assert!(finished.events.is_empty(), "{:?}", finished.events);
            // Parabolas: a step may be as long as the run; the first is short where steps are chosen.
            assert!(summary.steps <= 30 && summary.rejected_steps <= 4, "{friction}, {steps:?}: {summary:?}");
            assert_eq!(summary.contact.cone_violation, 0.0);
            // Each body falls as it would alone: 0.5 s of gravity and 1.3 m/s, to the roundings of a height of a metre.
            for (now, before) in finished.state.position.iter().zip(&start.position).skip(2).step_by(7) {
                let fallen = before - now - (1.3 * 0.5 + 0.5 * 9.81 * 0.25);
                assert!(fallen.abs() <= 1e-14, "{friction}, {steps:?}: {fallen:e}");
            }
        }
    }
}

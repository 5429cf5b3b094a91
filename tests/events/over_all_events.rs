//! Runs all of whose steps are over events (one stage): they converge to closed forms with first order, and with second where no event happens.

use crate::closed::parallelogram;
use crate::loose::{DOWN, cuboid, loose, on_floor, put, resting};
use crate::mechanisms::{GRAVITY, at_rest, double_pendulum, fixed, run};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::distance::{distance, probes};
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::Vector3;

/// Duration of the runs (s).
const DURATION: f64 = 1.5;

/// The ends of runs with steps of these lengths (s), none of which gains energy.
fn ends<const N: usize>(mechanism: &Mechanism, start: &State, steps: [f64; N]) -> [State; N] {
    steps.map(|step| {
        let finished = run(mechanism, start, DURATION, fixed(1, step));
        let (method, steps) = (&finished.method, finished.summary.steps);
        assert!(method.stages == 1 && method.order == 1 && method.first_order_steps == steps, "{method:?}");
        let (first, last) = (finished.summary.initial_energy.total(), finished.summary.final_energy.total());
        assert!(last - first <= 1e-12, "{:e} J gained", last - first);
        finished.state
    })
}

#[test]
fn steps_over_events_bring_a_bouncing_ball_and_a_sliding_block_to_their_closed_forms_with_first_order() {
    // A ball falls 0.6 m: its n-th flight begins with e^n v.
    let (radius, restitution): (f64, f64) = (0.05, 0.7);
    let mut ball = loose(DOWN, &[(1.0, Shape::Sphere { radius })]);
    on_floor(&mut ball, 0.0, restitution);
    let dropped = resting(&ball, &[Vector3::new(0.0, 0.0, radius + 0.6)]);
    let (mut begins, mut speed) = ((1.2 / GRAVITY).sqrt(), restitution * (1.2 * GRAVITY).sqrt());
    while begins + 2.0 * speed / GRAVITY < DURATION {
        begins += 2.0 * speed / GRAVITY;
        speed *= restitution;
    }
    let height = radius + speed * (DURATION - begins) - 0.5 * GRAVITY * (DURATION - begins).powi(2);
    // A block is thrown across a slope of 5 : 12 with friction 0.5, turns downhill and stops after 1.084 s.
    let (thrown, ratio) = (1.5, 0.5 / (5.0 / 12.0));
    let mut block = loose(Vector3::new(5.0, 0.0, -12.0) * (GRAVITY / 13.0), &[(1.0, cuboid(0.2, 0.2, 0.05))]);
    on_floor(&mut block, 0.5, 0.0);
    let (at, none) = (Vector3::new(0.0, 0.0, 0.05), Vector3::zeros());
    let mut sliding = State::zero(&block);
    put(&block, &mut sliding, 0, [at, none, Vector3::new(0.0, thrown, 0.0), none]);
    let unit = thrown * thrown / (GRAVITY * 5.0 / 13.0);
    let downhill = unit / 4.0 * (1.0 / (2.0 * ratio - 2.0) - 1.0 / (2.0 * ratio + 2.0));
    let across = unit / 2.0 * (1.0 / (2.0 * ratio - 1.0) + 1.0 / (2.0 * ratio + 1.0));
    for (name, mechanism, start, place, speed) in [
        ("ball", &ball, &dropped, Vector3::new(0.0, 0.0, height), 3.4),
        ("block", &block, &sliding, Vector3::new(downhill, across, 0.05), thrown),
    ] {
        let lengths = [4e-3, 1e-3, 2.5e-4];
        let errors =
            ends(mechanism, start, lengths).map(|end| (Vector3::from_column_slice(&end.position[..3]) - place).norm());
        println!("{name}: {errors:?}");
        // An event is off by h at most, and leaves the largest speed times that.
        for (error, length) in errors.iter().zip(lengths) {
            assert!(*error <= speed * length, "{name}: {errors:?}");
        }
        assert!(errors[2] < 0.25 * errors[0], "{name}: {errors:?}");
    }
}

#[test]
fn balls_that_meet_slowly_on_a_floor_part_again_in_steps_over_events() {
    // Gravity makes 0.04 m/s in two steps, and has no part along the normal of the two.
    let (radius, speed, restitution) = (0.05, 0.03, 0.5);
    let mut balls = loose(DOWN, &[(1.0, Shape::Sphere { radius }), (1.0, Shape::Sphere { radius })]);
    on_floor(&mut balls, 0.0, restitution);
    let mut start = resting(&balls, &[Vector3::new(-0.11, 0.0, radius), Vector3::new(0.0, 0.0, radius)]);
    start.velocity[0] = speed;
    let [end] = ends(&balls, &start, [2e-3]);
    let rates = [0, 1].map(|body| end.velocity[balls.bodies[body].joint.velocity_range().start]);
    let wanted = [0.5 * (1.0 - restitution) * speed, 0.5 * (1.0 + restitution) * speed];
    // 0.015 m/s both where they stayed together.
    for (rate, wanted) in rates.iter().zip(wanted) {
        assert!((rate - wanted).abs() < 1e-6, "{rates:?}, not {wanted}");
    }
}

#[test]
fn steps_over_events_have_second_order_where_nothing_happens() {
    let mut mechanism = double_pendulum(0.0);
    mechanism.nonsmooth.limits.clear();
    let start = at_rest(&mechanism, &[0.3, -0.2]);
    let exact = run(&mechanism, &start, DURATION, fixed(9, 0.01)).state;
    let errors = ends(&mechanism, &start, [4e-3, 2e-3, 1e-3])
        .map(|end| distance(&probes(&mechanism, &end), &probes(&mechanism, &exact)));
    println!("{errors:?}");
    for pair in errors.windows(2) {
        // A quarter, but for terms of the next order.
        assert!((3.8..4.2).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

#[test]
fn a_closed_loop_is_refused_in_steps_over_events() {
    let mechanism = parallelogram(0.0);
    let refused = StepChoice::Fixed { stages: 1, step: 1e-3 }.integrator(&mechanism, &[]).err().expect("an error");
    assert!(refused.to_string().contains("closed loops"), "{refused}");
}

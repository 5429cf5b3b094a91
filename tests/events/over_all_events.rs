//! Runs all of whose steps are over events (one stage): they converge to closed forms with first order, and with second where no event happens.

use crate::closed::parallelogram;
use crate::loose::{DOWN, cuboid, loose, on_floor, put, resting};
use crate::mechanisms::{GRAVITY, at_rest, coordinate, double_pendulum, fixed, friction, hinge, limit, motor, run};
use catena::mechanism::description::closure::Mimic;
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::{Interpolation, Target};
use catena::mechanism::motion::distance::{distance, probes};
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::StepChoice;
use nalgebra::Vector3;
use std::path::Path;

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
fn steps_over_events_keep_closed_loops_with_second_order_where_nothing_happens() {
    // Six hinges in space, with one equation that the others imply, and ten four-bars in a row.
    for (name, lengths) in [("bricard", [4e-3, 2e-3, 1e-3]), ("four_bar_10", [2e-3, 1e-3, 5e-4])] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("robots/{name}.toml"));
        let scene = read_scene(&file, &PackagePath::default()).expect("a scene");
        let (model, start) = Model::from_scene(&scene).expect("a model");
        let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
        let mechanism = &model.mechanism;
        let exact = run(mechanism, &start, DURATION, StepChoice::Unestimated(1e-9)).state;
        let errors = ends(mechanism, &start, lengths).map(|end| {
            let bodies = body_states(mechanism, &end);
            for joint in &mechanism.loops {
                // Roundings of places of some ten metres, in positions and in velocities.
                let (gap, rate) = loop_gaps(joint, &bodies).largest();
                assert!(gap <= 1e-13 && rate <= 1e-12, "{name}: {gap:e} {rate:e}");
            }
            distance(&probes(mechanism, &end), &probes(mechanism, &exact))
        });
        println!("{name}: {errors:?}");
        for pair in errors.windows(2) {
            // A quarter, but for terms of the next order.
            assert!((3.7..4.3).contains(&(pair[0] / pair[1])), "{name}: {errors:?}");
        }
    }
}

/// A parallelogram with dry friction, a motor and a limit that it strikes, and an arm on it whose joint follows its first crank and reaches a limit of its own.
fn parallelogram_with_follower() -> (Mechanism, State) {
    let mut mechanism = parallelogram(0.45);
    let mut arm = hinge("arm", Some(1), Vector3::new(0.0, 0.0, -0.2), 0.3, 0.5, 0.02);
    arm.joint.position_index = 3;
    arm.joint.velocity_index = 3;
    // The coupler carries it, and comes before the second bar.
    let mut bodies = mechanism.bodies.clone();
    bodies.insert(2, arm);
    let loops = std::mem::take(&mut mechanism.loops);
    let mut whole = crate::mechanisms::mechanism(bodies);
    whole.loops = loops;
    whole.loops[0].b.body = Some(3);
    let own = |body: usize| coordinate(&whole, body);
    let follows = Mimic {
        name: "arm".into(),
        follower: own(2),
        leader: own(0),
        multiplier: -0.7,
        offset: 0.2,
        more: Vec::new(),
        over_time: None,
    };
    whole.mimics.push(follows);
    for (body, effort) in [(0, 0.45), (1, 0.9), (2, 0.2), (3, 0.45)] {
        friction(&mut whole, body, effort);
    }
    limit(&mut whole, 0, -0.3, 1.5, 0.4);
    // 0.2 − 0.7 q is −0.71 where q is 1.3, and 0.27 where it is −0.1.
    limit(&mut whole, 2, -0.9, 0.27, 0.0);
    let target = Target::table(&[(0.0, 0.0), (1.0, 2.0), (2.0, -1.0)], Interpolation::Cubic).expect("a table");
    motor(&mut whole, 3, MotorLaw::Velocity { kd: 8.0 }, target, 5.0, 0.0);
    let start = at_rest(&whole, &[1.3, -1.3, 0.2 - 0.7 * 1.3, 1.3]);
    (whole, start)
}

#[test]
fn limits_friction_and_motors_of_closed_loops_and_followers_converge_with_first_order_in_steps_over_events() {
    let (mechanism, start) = parallelogram_with_follower();
    let exact = run(&mechanism, &start, DURATION, StepChoice::Unestimated(1e-9));
    for kind in [EventKind::LimitImpact, EventKind::Saturation, EventKind::Reversal] {
        assert!(exact.summary.events.of(kind) > 0, "no {}: {:?}", kind.name(), exact.events);
    }
    let lengths = [4e-3, 1e-3, 2.5e-4];
    let finished = lengths.map(|step| run(&mechanism, &start, DURATION, fixed(1, step)));
    let errors =
        finished.each_ref().map(|own| distance(&probes(&mechanism, &own.state), &probes(&mechanism, &exact.state)));
    println!("{errors:?}");
    for ((error, own), length) in errors.iter().zip(&finished).zip(lengths) {
        // An event is off by h at most, and leaves the largest speed times that: points of the coupler move at up to 3 m/s.
        assert!(*error <= 3.0 * length, "{errors:?}");
        assert!(own.summary.max_violation.position < 1e-13, "{:?}", own.summary);
        assert!(own.summary.max_relative_energy_error < 1e-12, "{:?}", own.summary);
    }
    assert!(errors[2] < 0.25 * errors[0], "{errors:?}");
}

#[test]
fn a_joint_that_is_moved_in_time_is_refused_in_steps_over_events() {
    let mut mechanism = double_pendulum(0.0);
    let joint = coordinate(&mechanism, 0);
    let target = Target::table(&[(0.0, 0.0), (1.0, 2.0)], Interpolation::Cubic).expect("a table");
    mechanism.mimics.push(Mimic::moved("moved".into(), joint, target));
    let refused = StepChoice::Fixed { stages: 1, step: 1e-3 }.integrator(&mechanism, &[]).err().expect("an error");
    assert!(refused.to_string().contains("moved in time"), "{refused}");
}

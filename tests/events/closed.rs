//! Closed loops: a parallelogram with friction in all its hinges is a friction pendulum (J2b).

use crate::exact::{answer, near};
use crate::mechanisms::*;
use catena::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::{Interpolation, Target};
use catena::mechanism::motion::event::EventKind;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// Two bars of J1's data at x = 0 and x = 2 that carry a coupler of 2 kg, 1 m below their hinges; all axes along y.
fn parallelogram(effort: f64) -> Mechanism {
    let bar = |name: &str, x: f64| hinge(name, None, Vector3::new(x, 0.0, 0.0), 0.5, 2.0, 0.02);
    // The coupler hangs on the first bar, 1 m below its hinge; its centre of mass is 1 m further along x.
    let mut coupler = hinge("coupler", Some(0), Vector3::new(0.0, 0.0, -0.5), 0.0, 2.0, 0.1);
    let turn = Rotation3::from_matrix_unchecked(Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0));
    coupler.joint.on_child = Pose::from_parts(Translation3::new(-1.0, 0.0, 0.0), turn);
    let mut mechanism = mechanism(vec![bar("first", 0.0), coupler, bar("second", 2.0)]);
    let end = |body: usize, at: Vector3<f64>| Attachment {
        body: Some(body),
        frame: Pose::from_parts(Translation3::from(at), turn),
    };
    mechanism.loops.push(LoopJoint {
        name: "closure".into(),
        kind: LoopKind::Revolute,
        a: end(1, Vector3::new(1.0, 0.0, 0.0)),
        b: end(2, Vector3::new(0.0, 0.0, -0.5)),
    });
    // Friction of the hinge that closes the loop is that of the coupler's other end: it turns as much.
    friction(&mut mechanism, 0, effort);
    friction(&mut mechanism, 1, 2.0 * effort);
    friction(&mut mechanism, 2, effort);
    mechanism
}

#[test]
fn a_parallelogram_with_friction_in_its_hinges_turns_like_a_friction_pendulum() {
    let Some(exact) = answer("J2") else { return };
    let mechanism = parallelogram(0.45);
    let done = run(&mechanism, &at_rest(&mechanism, &[1.3, -1.3, 1.3]), 13.0, fixed(9, 0.05));
    // √(3.04/(4 · 0.52))
    let slower = (3.04_f64 / (4.0 * 0.52)).sqrt();
    let turns: Vec<f64> = of_kind(&done, EventKind::Reversal).iter().map(|event| event.time).collect();
    for time in exact[..12].iter().map(|turn| turn[2]) {
        let nearest = turns.iter().map(|found| (found - slower * time).abs()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-10, "no turn at {}: {turns:?}", slower * time);
    }
    near(done.state.position[0], exact[12][1], 1e-10);
    assert!(done.state.velocity.iter().all(|&rate| rate == 0.0), "{:?}", done.state);
    assert!(of_kind(&done, EventKind::Stick).len() == 3, "{:?}", done.events);
    assert!(done.summary.max_relative_energy_error < 1e-11, "{:?}", done.summary);
}

#[test]
fn a_loop_with_friction_limits_and_a_motor_balances_its_energy_and_is_held_in_the_end() {
    let mut mechanism = parallelogram(0.45);
    limit(&mut mechanism, 0, -0.3, 1.35, 0.3);
    let target =
        Target::table(&[(0.0, 0.0), (1.0, 2.0), (2.0, -1.0), (3.0, 0.0)], Interpolation::Cubic).expect("a table");
    motor(&mut mechanism, 2, MotorLaw::Velocity { kd: 8.0 }, target, 12.0, 0.0);
    let done = run(&mechanism, &at_rest(&mechanism, &[1.3, -1.3, 1.3]), 8.0, fixed(9, 0.02));
    for kind in [EventKind::LimitImpact, EventKind::Saturation, EventKind::Unsaturation, EventKind::Stick] {
        assert!(done.summary.events.of(kind) > 0, "no {}: {:?}", kind.name(), done.events);
    }
    assert!(done.summary.max_relative_energy_error < 1e-10, "{:?}", done.summary);
    assert!(done.summary.max_violation.position < 1e-12, "{:?}", done.summary);
    // The same by another number of stages and other steps.
    let again = run(&mechanism, &at_rest(&mechanism, &[1.3, -1.3, 1.3]), 8.0, fixed(7, 0.013));
    for (one, other) in done.state.position.iter().zip(&again.state.position) {
        near(*one, *other, 1e-9);
    }
    assert_eq!(done.summary.events, again.summary.events);
}

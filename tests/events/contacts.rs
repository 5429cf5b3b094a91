//! Contacts with a floor against exact answers: impact, sliding, rolling and rest.

use crate::exact::{answer, near};
use crate::mechanisms::{GRAVITY, fixed, of_kind, run};
use catena::instant::exerting::reactions::Reactions;
use catena::mechanism::description::contact::{Collider, ContactPair, Shape};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

/// A free body with shapes over a floor at z = 0, with this friction and restitution.
pub fn over_floor(
    mass: f64,
    inertia: Vector3<f64>,
    shapes: Vec<(Shape, Pose)>,
    gravity: Vector3<f64>,
    friction: f64,
    restitution: f64,
) -> Mechanism {
    let joint = Joint::new("free", JointKind::Floating, Pose::identity(), Pose::identity());
    let body = Body { name: "body".into(), parent: None, mass, inertia, joint };
    let mut mechanism = Mechanism::new("contact", gravity, vec![body]).expect("one body");
    let nonsmooth = &mut mechanism.nonsmooth;
    nonsmooth.colliders.push(Collider::still("floor", None, Pose::identity(), Shape::HalfSpace));
    for (number, (shape, pose)) in shapes.into_iter().enumerate() {
        nonsmooth.colliders.push(Collider::still(format!("shape{number}"), Some(0), pose, shape));
        nonsmooth.pairs.push(ContactPair::without_moments(number, [0, number + 1], friction, restitution));
    }
    mechanism
}

/// A solid ball.
pub fn ball(radius: f64, gravity: Vector3<f64>, friction: f64, restitution: f64) -> Mechanism {
    let inertia = Vector3::repeat(0.4 * radius * radius);
    over_floor(1.0, inertia, vec![(Shape::Sphere { radius }, Pose::identity())], gravity, friction, restitution)
}

/// The block of C2 and C3: 0.4 × 0.4 × 0.1 and 1 kg, on the slope 5:12, which lies level.
pub fn block(friction: f64) -> Mechanism {
    let half = Vector3::new(0.2, 0.2, 0.05);
    let inertia = Vector3::new(0.04 + 0.0025, 0.04 + 0.0025, 0.08) / 3.0;
    let gravity = Vector3::new(5.0 / 13.0, 0.0, -12.0 / 13.0) * GRAVITY;
    over_floor(1.0, inertia, vec![(Shape::Box { half }, Pose::identity())], gravity, friction, 0.0)
}

/// A free body at a place with velocities of its centre of mass and its spin.
pub fn placed(mechanism: &Mechanism, at: Vector3<f64>, velocity: Vector3<f64>, spin: Vector3<f64>) -> State {
    let mut state = State::zero(mechanism);
    state.position[..3].copy_from_slice(at.as_slice());
    state.velocity[..3].copy_from_slice(velocity.as_slice());
    state.velocity[3..].copy_from_slice(spin.as_slice());
    state
}

#[test]
fn a_ball_bounces_to_rest() {
    let Some(lines) = answer("C1") else { return };
    let mechanism = ball(0.05, Vector3::new(0.0, 0.0, -GRAVITY), 0.3, 0.7);
    let start = placed(&mechanism, Vector3::new(0.0, 0.0, 0.65), Vector3::zeros(), Vector3::zeros());
    let finished = run(&mechanism, &start, 3.0, fixed(3, 0.05));
    let impacts = of_kind(&finished, EventKind::ContactImpact);
    for (line, impact) in lines[..6].iter().zip(&impacts) {
        near(impact.time, line[1], 1e-12);
    }
    let rest = of_kind(&finished, EventKind::Rest);
    assert_eq!(rest.len(), 1, "{:?}", finished.events.last());
    near(rest[0].time, lines[6][0], 1e-12);
    near(impacts[0].impulse.expect("an impulse"), lines[6][1], 1e-11);
    near(finished.state.position[2], 0.05, 1e-12);
    assert_eq!(finished.state.velocity[2], 0.0);
}

#[test]
fn a_block_on_a_slope_stops_and_stays_or_slides_back() {
    let Some(lines) = answer("C2") else { return };
    let up = Vector3::new(-2.0, 0.0, 0.0);
    for (friction, line) in [(0.45, &lines[0]), (0.25, &lines[1])] {
        let mechanism = block(friction);
        let start = placed(&mechanism, Vector3::new(0.0, 0.0, 0.05), up, Vector3::zeros());
        let finished = run(&mechanism, &start, 2.0, fixed(3, 0.05));
        println!("{:?}", finished.events);
        let stops = finished.events.iter().find(|event| event.time > 0.0).expect("it stops");
        // A slip stops to 1e-10 of the fastest, at 8 m/s².
        near(stops.time, line[1], 3e-11);
        let state = &finished.state;
        if friction == 0.45 {
            near(-state.position[0], line[2], 1e-12);
            assert_eq!(state.velocity, vec![0.0; 6]);
        } else {
            near(-state.position[0], lines[2][1], 1e-11);
            near(-state.velocity[0], lines[2][2], 1e-11);
        }
        near(state.position[2], 0.05, 1e-13);
    }
}

#[test]
fn a_block_thrown_across_a_slope_stops_where_the_cone_says() {
    let Some(lines) = answer("C3") else { return };
    let mechanism = block(0.5);
    let start = placed(&mechanism, Vector3::new(0.0, 0.0, 0.05), Vector3::new(0.0, 1.5, 0.0), Vector3::zeros());
    let finished = run(&mechanism, &start, 2.0, fixed(9, 0.1));
    println!("{:?}", finished.events);
    let stops = of_kind(&finished, EventKind::Stick);
    near(stops[0].time, lines[0][0], 1e-10);
    near(finished.state.position[0], lines[0][1], 1e-10);
    near(finished.state.position[1], lines[0][2], 1e-10);
    assert_eq!(finished.state.velocity, vec![0.0; 6]);
}

#[test]
fn a_ball_with_backspin_slides_until_it_rolls() {
    let Some(lines) = answer("C4") else { return };
    let mechanism = ball(0.12, Vector3::new(0.0, 0.0, -GRAVITY), 0.3, 0.0);
    let at = Vector3::new(0.0, 0.0, 0.12);
    let start = placed(&mechanism, at, Vector3::new(1.8, 0.0, 0.0), Vector3::new(0.0, -15.0, 0.0));
    let finished = run(&mechanism, &start, 3.0, fixed(5, 0.05));
    println!("{:?}", finished.events);
    let rolls = of_kind(&finished, EventKind::Stick);
    near(rolls[0].time, lines[0][0], 1e-12);
    near(finished.state.velocity[0], lines[0][2], 1e-12);
    near(finished.state.position[0], lines[0][4], 1e-11);
}

#[test]
fn a_billiard_ball_curves_until_it_rolls() {
    let Some(lines) = answer("C5") else { return };
    let mechanism = ball(0.12, Vector3::new(0.0, 0.0, -GRAVITY), 0.3, 0.0);
    let at = Vector3::new(0.0, 0.0, 0.12);
    let start = placed(&mechanism, at, Vector3::new(2.0, 0.0, 0.0), Vector3::new(12.0, -10.0, 25.0));
    let finished = run(&mechanism, &start, 2.0, fixed(9, 0.05));
    println!("{:?}", finished.events);
    let rolls = of_kind(&finished, EventKind::Stick);
    near(rolls[0].time, lines[0][2], 1e-10);
    near(finished.state.position[0], lines[1][0], 1e-10);
    near(finished.state.position[1], lines[1][1], 1e-10);
}

#[test]
fn what_a_floor_carries_no_joint_carries() {
    let mechanism = block(0.5);
    let start = placed(&mechanism, Vector3::new(0.0, 0.0, 0.05), Vector3::zeros(), Vector3::zeros());
    let bodies = body_states(&mechanism, &start);
    let mut reactions = Reactions::new(&mechanism);
    let (carried, _) = reactions.of_placed(&start.position, &start.velocity, &bodies);
    // Nothing connects the block with the world but its contacts; roundings of 10 N and 0.5 N m.
    assert!(carried[0].force.norm() < 1e-13 && carried[0].torque.norm() < 1e-13, "{:?}", carried[0]);
    // Without friction along the slope the rest would be that it is held there.
    let (forces, _) = reactions.at(&[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0], &[0.0; 6]);
    assert!(forces[0].force.norm() < 1e-13);
}

//! Contacts between bodies and of other shapes, against closed forms; and shapes that never meet.

use crate::exact::near;
use crate::loose::{DOWN, cuboid, loose, meet, obstacle, on_floor, put, resting};
use crate::mechanisms::{GRAVITY, double_pendulum, fixed, of_kind, run};
use catena::mechanism::description::contact::{Collider, Shape};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

#[test]
fn a_box_that_slides_on_another_drags_it_along_until_both_have_one_velocity() {
    let (top, bottom, friction, speed) = (1.0, 3.0, 0.4, 1.5);
    let mut boxes = loose(DOWN, &[(bottom, cuboid(1.0, 0.5, 0.1)), (top, cuboid(0.1, 0.1, 0.1))]);
    let floor = obstacle(&mut boxes, Shape::HalfSpace, Vector3::zeros());
    meet(&mut boxes, floor, 0, 0.0, 0.0);
    meet(&mut boxes, 0, 1, friction, 0.0);
    let mut start = resting(&boxes, &[Vector3::new(0.0, 0.0, 0.1), Vector3::new(-0.3, 0.0, 0.3)]);
    start.velocity[6] = speed;
    let finished = run(&boxes, &start, 1.0, fixed(5, 0.05));
    println!("{:?}", finished.events);
    let stops = speed / (friction * GRAVITY * (1.0 + top / bottom));
    let sticks = of_kind(&finished, EventKind::Stick);
    near(sticks[0].time, stops, 1e-10);
    let together = speed * top / (top + bottom);
    near(finished.state.velocity[0], together, 1e-12);
    near(finished.state.velocity[6], together, 1e-12);
    let slid = 0.5 * speed * stops;
    near(finished.state.position[7] - finished.state.position[0], -0.3 + slid, 1e-10);
    near(finished.state.position[9], 0.3, 1e-12);
}

#[test]
fn a_ball_without_friction_leaves_a_larger_one_at_two_thirds_of_its_height() {
    let (radius, large) = (0.05, 0.5);
    let mut balls = loose(DOWN, &[(1.0, Shape::Sphere { radius })]);
    let under = obstacle(&mut balls, Shape::Sphere { radius: large }, Vector3::zeros());
    meet(&mut balls, under, 0, 0.0, 0.0);
    let (distance, angle) = (radius + large, 0.3_f64);
    let start = resting(&balls, &[Vector3::new(angle.sin(), 0.0, angle.cos()) * distance]);
    let finished = run(&balls, &start, 0.8, fixed(9, 0.02));
    let leaves = of_kind(&finished, EventKind::Release);
    assert_eq!(leaves.len(), 1, "{:?}", finished.events);
    let there = run(&balls, &start, leaves[0].time, fixed(9, 0.02)).state;
    // m g cos θ = m v²/d and v² = 2 g d (cos θ₀ − cos θ).
    near(there.position[2], 2.0 / 3.0 * distance * angle.cos(), 1e-10);
    near(there.velocity[0].hypot(there.velocity[2]), (GRAVITY * there.position[2]).sqrt(), 1e-10);
}

#[test]
fn two_balls_that_meet_off_centre_change_their_velocities_as_coulomb_and_newton_say() {
    let radius = 0.1;
    for (friction, restitution) in [(0.0, 1.0), (0.05, 0.8), (2.0, 0.5)] {
        let ball = Shape::Sphere { radius };
        let mut balls = loose(Vector3::zeros(), &[(1.0, ball.clone()), (1.0, ball)]);
        meet(&mut balls, 0, 1, friction, restitution);
        let (sine, cosine) = (0.6, 0.8);
        // They touch where the line between them is (0.8, 0.6), half a second after the start.
        let mut start = State::zero(&balls);
        let none = Vector3::zeros();
        let second = Vector3::new(cosine, sine, 0.0) * (2.0 * radius);
        put(&balls, &mut start, 0, [Vector3::new(-0.5, 0.0, 0.0), none, Vector3::x(), none]);
        put(&balls, &mut start, 1, [second, none, none, none]);
        let finished = run(&balls, &start, 0.7, fixed(5, 0.1));
        let impacts = of_kind(&finished, EventKind::ContactImpact);
        assert_eq!(impacts.len(), 1, "{:?}", finished.events);
        near(impacts[0].time, 0.5, 1e-12);
        let normal = 0.5 * (1.0 + restitution) * cosine;
        near(impacts[0].impulse.expect("an impulse"), normal, 1e-12);
        // Rolling balls take an impulse of a seventh of the slip, whose mobility is 2 (1 + 5/2).
        let along = f64::min(friction * normal, sine / 7.0);
        let wanted = Vector3::new(cosine, sine, 0.0) * normal - Vector3::new(-sine, cosine, 0.0) * along;
        let velocity = Vector3::from_column_slice(&finished.state.velocity[6..9]);
        assert!((velocity - wanted).norm() < 1e-12, "{friction}: {velocity} for {wanted}");
        // A torque r × P about z, on both alike.
        near(finished.state.velocity[5].abs(), radius * along / (0.4 * radius * radius), 1e-11);
        near(finished.state.velocity[11], finished.state.velocity[5], 1e-12);
    }
}

#[test]
fn a_lying_capsule_slides_until_it_rolls() {
    let (radius, friction, speed) = (0.1, 0.3, 2.0);
    let mut log = loose(DOWN, &[(1.0, Shape::Capsule { radius, half: 0.3 })]);
    on_floor(&mut log, friction, 0.0);
    let mut start = State::zero(&log);
    // Its axis lies along y.
    let turned = Vector3::x() * std::f64::consts::FRAC_PI_2;
    let at = Vector3::new(0.0, 0.0, radius);
    put(&log, &mut start, 0, [at, turned, Vector3::x() * speed, Vector3::zeros()]);
    let finished = run(&log, &start, 2.0, fixed(9, 0.05));
    println!("{:?}", finished.events);
    // I = m r²/2 about its axis: rolls at v₀/(3 μ g) with two thirds of the speed.
    let rolls = of_kind(&finished, EventKind::Stick);
    let time = speed / (3.0 * friction * GRAVITY);
    near(rolls[0].time, time, 1e-10);
    let state = &finished.state;
    near(state.velocity[0], 2.0 / 3.0 * speed, 1e-10);
    near(state.position[0], speed * time * 5.0 / 6.0 + 2.0 / 3.0 * speed * (2.0 - time), 1e-10);
    near(state.position[2], radius, 1e-12);
    near(state.velocity[5].abs(), 2.0 / 3.0 * speed / radius, 1e-9);
}

#[test]
fn shapes_that_never_meet_change_a_motion_by_roundings_alone() {
    let plain = {
        let mut pendulum = double_pendulum(0.0);
        pendulum.nonsmooth.limits.clear();
        pendulum
    };
    let mut with = plain.clone();
    for body in [Some(0), Some(1)] {
        let shape = Shape::Capsule { radius: 0.05, half: 0.2 };
        with.nonsmooth.colliders.push(Collider::still("link", body, Pose::identity(), shape));
    }
    let floor = obstacle(&mut with, Shape::HalfSpace, Vector3::new(0.0, 0.0, -3.0));
    meet(&mut with, floor, 0, 0.5, 0.5);
    meet(&mut with, floor, 1, 0.5, 0.5);
    let mut start = State::zero(&plain);
    start.position.copy_from_slice(&[0.8, 0.5]);
    let [plain, with] = [&plain, &with].map(|mechanism| run(mechanism, &start, 2.0, fixed(5, 0.02)));
    assert!(with.events.is_empty(), "{:?}", with.events);
    assert_eq!(with.summary.steps, plain.summary.steps);
    for (one, other) in with.state.position.iter().zip(&plain.state.position) {
        near(*one, *other, 1e-13);
    }
    for (one, other) in with.state.velocity.iter().zip(&plain.state.velocity) {
        near(*one, *other, 1e-12);
    }
}

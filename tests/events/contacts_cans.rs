//! A can that slides off another can or off a box, and cans that stand on each other: rims of two discs in one plane, and edges along the tangent of a rim.

use crate::loose::{DOWN, cuboid, loose, meet, obstacle, on_floor, put, resting, solid};
use crate::mechanisms::{GRAVITY, fixed, of_kind, run};
use crate::runge_kutta::runge_kutta;
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::{Rotation3, Vector3};

/// Radius and half height (m) and mass (kg) of a can.
const RADIUS: f64 = 0.035;
const HALF: f64 = 0.06;
const MASS: f64 = 0.4;

fn can() -> Shape {
    Shape::Cylinder { radius: RADIUS, half: HALF }
}

/// A can that starts flat on another shape whose upper side is at z = 0, which is turned about z, with its axis at a place and a velocity.
fn sliding(under: Shape, turned: f64, friction: f64, [at, velocity]: [Vector3<f64>; 2]) -> (Mechanism, State) {
    let mut mechanism = loose(DOWN, &[(MASS, can())]);
    let below = obstacle(&mut mechanism, under, Vector3::zeros());
    mechanism.nonsmooth.colliders[below].pose =
        Pose::from_parts(Vector3::new(0.0, 0.0, -HALF).into(), Rotation3::from_axis_angle(&Vector3::z_axis(), turned));
    meet(&mut mechanism, below, 0, friction, 0.0);
    let mut start = State::zero(&mechanism);
    let none = Vector3::zeros();
    put(&mechanism, &mut start, 0, [at + Vector3::z() * HALF, none, velocity, none]);
    (mechanism, start)
}

/// How far the axis of the can has come at a time, along its way and up (m), and its angle (rad), by the motion in a plane. A corner at RADIUS along the way
/// touches the base at s from its middle. With e along the base and n out of it into the can, the centre is at `C − s e + h n`:
///
/// ```text
///     m(−s̈ + s θ̇² + h θ̈) = m g sin θ − μ N,     m(s θ̈ + 2 ṡ θ̇ − h θ̇²) = N − m g cos θ,     J θ̈ = (μ h − s) N
/// ```
///
/// from where the centre of pressure is at the corner, `s = μ h`, to where the corner is at the end of the base, `s = −RADIUS`; it falls freely afterwards. While it is not there N has to be positive.
fn slid_off(speed: f64, friction: f64, until: f64) -> [f64; 3] {
    let inertia = solid(MASS, &can()).x;
    let tips = RADIUS - friction * HALF;
    let brake = friction * GRAVITY;
    // x = v t − μ g t²/2.
    let begin = 2.0 * tips / (speed + (speed * speed - 2.0 * brake * tips).sqrt());
    let slope = |&[s, q, u, w]: &[f64; 4]| {
        // s̈ and θ̈ of N, which follows from the normal direction.
        let turning = (friction * HALF - s) / inertia;
        let push = (MASS * GRAVITY * q.cos() + MASS * (2.0 * u * w - HALF * w * w)) / (1.0 - MASS * s * turning);
        let along = s * w * w + HALF * turning * push - GRAVITY * q.sin() + friction * push / MASS;
        [u, w, along, turning * push]
    };
    let step = |y: [f64; 4], h: f64| runge_kutta(&slope, &y, h);
    let (mut y, mut time, h) = ([friction * HALF, 0.0, brake * begin - speed, 0.0], begin, 2e-6_f64);
    while time < until && y[0] > -RADIUS {
        let next = step(y, h.min(until - time));
        if next[0] <= -RADIUS {
            // The part of the step to the end of the base.
            let mut part = h * 0.5;
            for _ in 0..60 {
                let [s, _, u, _] = step(y, part);
                part -= (s + RADIUS) / u;
            }
            (y, time) = (step(y, part), time + part);
            break;
        }
        (y, time) = (next, time + h.min(until - time));
    }
    let [s, q, u, w] = y;
    let (e, n) = ([q.cos(), -q.sin()], [q.sin(), q.cos()]);
    let at = [0, 1].map(|i| [RADIUS, 0.0][i] - s * e[i] + HALF * n[i]);
    let velocity = [0, 1].map(|i| -u * e[i] + s * w * n[i] + HALF * w * e[i]);
    let left = until - time;
    [at[0] + velocity[0] * left, at[1] + velocity[1] * left - 0.5 * GRAVITY * left * left, q + w * left]
}

/// Runs a can off another shape in a direction, and says how far it is from the motion in the plane (m), and what happened.
fn off_the_plane(
    under: Shape,
    [turned, direction]: [f64; 2],
    [speed, friction]: [f64; 2],
    until: f64,
    steps: StepChoice,
) -> (f64, Vec<EventKind>) {
    let towards = Vector3::new(direction.cos(), direction.sin(), 0.0);
    let (mechanism, start) = sliding(under, turned, friction, [Vector3::zeros(), towards * speed]);
    let done = run(&mechanism, &start, until, steps);
    let [along, up, angle] = slid_off(speed, friction, until);
    let axis = Vector3::z().cross(&towards) * (0.5 * angle).sin();
    let wanted = [towards.x * along, towards.y * along, up, (0.5 * angle).cos(), axis.x, axis.y, axis.z];
    let off = wanted.iter().zip(&done.state.position).map(|(wanted, found)| (wanted - found).abs());
    (off.fold(0.0, f64::max), done.events.iter().map(|event| event.kind).collect())
}

#[test]
fn a_can_that_slides_off_another_tips_over_its_rim_and_leaves_it_in_every_direction() {
    for direction in [0.0, 0.3, 0.785, 2.2] {
        for [speed, friction, until] in [[0.3, 0.0, 0.25], [0.8, 0.2, 0.1], [0.8, 0.2, 0.3]] {
            for steps in [fixed(9, 0.01), StepChoice::Tolerance(1e-9)] {
                let (off, events) = off_the_plane(can(), [0.0, direction], [speed, friction], until, steps);
                println!("{direction} {friction} {until} {steps:?}: {off:e} m, {events:?}");
                // The tip begins with no acceleration, which is told from rest at 1e-10 of gravity: 1e-8 s late in a motion of 1 m/s.
                let bound = if direction == 0.0 { 1e-9 } else { 1e-10 };
                assert!(off < bound, "{direction}, {friction}, {until}: {off:e} m");
                assert!(events.iter().all(|kind| *kind == EventKind::Release), "{events:?}");
            }
        }
    }
}

#[test]
fn a_can_that_slides_off_a_box_leaves_its_edge_where_that_is_the_tangent_of_its_rim() {
    for direction in [0.0, 0.3, 2.2] {
        for [speed, friction, until] in [[0.3, 0.0, 0.25], [0.8, 0.2, 0.3]] {
            let under = cuboid(RADIUS, 0.05, HALF);
            let steps = fixed(9, 0.005);
            let (off, events) = off_the_plane(under, [direction, direction], [speed, friction], until, steps);
            println!("{direction} {friction} {until}: {off:e} m, {events:?}");
            assert!(off < 1e-9, "{direction}, {friction}, {until}: {off:e} m");
            assert!(events.iter().all(|kind| *kind == EventKind::Release), "{events:?}");
        }
    }
}

#[test]
fn a_can_that_slides_off_beside_the_middle_tips_when_its_centre_passes_the_rim() {
    // Without friction its axis goes straight, and nothing but gravity turns it: |x₀ + v t| = RADIUS.
    let (at, velocity) = (Vector3::new(0.0, 0.012, 0.0), Vector3::new(0.3, 0.05, 0.0));
    let (square, half): (f64, f64) = (velocity.norm_squared(), velocity.dot(&at));
    let tips = (-half + (half * half + square * (RADIUS * RADIUS - at.norm_squared())).sqrt()) / square;
    let (mechanism, start) = sliding(can(), 0.0, 0.0, [at, velocity]);
    for steps in [fixed(5, 0.01), fixed(9, 0.01)] {
        let before = run(&mechanism, &start, tips - 1e-6, steps).state;
        println!("before: {:?}", before.velocity);
        // It has not begun to turn, to the rounding of forces.
        assert!(before.velocity[3..].iter().all(|rate| rate.abs() < 1e-9), "{:?}", before.velocity);
        let after = run(&mechanism, &start, tips + 1e-3, steps).state;
        // Its centre passes the rim at v·r/R, and what turns it over the rim grows with it: J ω = m g (v·r/R) t²/2. Along the rim it sways.
        let place = at + velocity * tips;
        let wanted = 0.5 * MASS * GRAVITY * (velocity.dot(&place) / RADIUS) * 1e-6 / solid(MASS, &can()).x;
        let rate = Vector3::from_column_slice(&after.velocity[3..]).dot(&Vector3::z().cross(&place)) / RADIUS;
        println!("after: {rate:e} for {wanted:e}");
        // It has begun. At the first instant the point that touches can be anywhere on the rim, so the sway has any size.
        assert!(rate > 0.5 * wanted && rate < 2.0 * wanted, "{rate:e} for {wanted:e}");
    }
    let [one, other] = [fixed(9, 0.01), fixed(9, 0.004)].map(|steps| run(&mechanism, &start, 0.4, steps));
    let off = one.state.position.iter().zip(&other.state.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("{off:e} m apart; {:?} {:?}", one.summary, one.events);
    assert!(one.summary.max_relative_energy_error < 1e-9, "{:?}", one.summary);
    assert!(of_kind(&one, EventKind::Release).len() == 1, "{:?}", one.events);
}

#[test]
fn cans_that_stand_on_each_other_stay_for_ever_and_carry_their_weights() {
    for (beside, turned) in [(0.0, 0.0), (0.01, 0.4), (0.034, 2.0)] {
        let mut mechanism = loose(DOWN, &[(MASS, can()), (MASS, can())]);
        on_floor(&mut mechanism, 0.5, 0.0);
        let aside = Vector3::new(f64::cos(turned), f64::sin(turned), 0.0) * beside;
        let start = resting(&mechanism, &[Vector3::z() * HALF, aside + Vector3::z() * (3.0 * HALF)]);
        let done = run(&mechanism, &start, 10.0, fixed(5, 0.01));
        assert_eq!(done.state.position, start.position, "{beside}");
        // The floor with the lower can, and the cans with each other, in the order of their pairs.
        for (pair, wanted) in [(0, 2.0 * MASS * GRAVITY), (1, MASS * GRAVITY)] {
            let forces = done.contacts.iter().filter(|point| point.pair == pair).map(|point| point.force);
            let sum: Vector3<f64> = forces.sum();
            println!("{beside} {pair}: {sum:?} for {wanted}");
            assert!((sum.norm() - wanted).abs() < 1e-9 * wanted, "{beside}, {pair}: {sum:?}");
        }
    }
}

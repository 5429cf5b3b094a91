//! The contacts of a state that no step has met, with their forces: a log begins with them.
//!
//! ```text
//!     few contacts:    the problem of accelerations in that state, dense                       `instant::exerting::exerted`
//!     many:            f = p/h,  p the impulses of a step over events of h = 1e-4 s from there  (B) of `crowd/step.rs`
//! ```
//!
//! Impulses p in N s. Both have the same limit at rest. There are many contacts where a run begins with steps over events if they keep to the tolerance,
//! from 98 contacts on: 256 bricks of a wall have a thousand, and their dense problem took more than three minutes and 2 GB.

use crate::events::crowd::contacts::{Scene, has_row};
use crate::events::crowd::step::Crowd;
use crate::events::price::{CHEAP, decision};
use crate::instant::dynamics::response::Response;
use crate::instant::exerting::exerted::Exerted;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::touching::Touching;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::state::State;

/// h (s).
const STEP: f64 = 1e-4;

/// The contacts of a state in which motors alone drive, in the order of their pairs; without those at which there is an impact, if there are few.
pub fn first_contacts(mechanism: &Mechanism, state: &State) -> Vec<ContactPoint> {
    by_step(mechanism, state, CHEAP).unwrap_or_else(|| Exerted::contacts(mechanism, state))
}

/// The same by a step over events, if a decision of its mode would take more than this (s of CPU) and the step can be made.
fn by_step(mechanism: &Mechanism, state: &State, least: f64) -> Option<Vec<ContactPoint>> {
    if mechanism.nonsmooth.pairs.is_empty() || mechanism.bodies.is_empty() {
        return None;
    }
    let (elements, touching) = (Elements::new(mechanism), Touching::new(mechanism));
    if touching.pairs.need_events() {
        return None;
    }
    let scene = Scene { whole: mechanism, elements: &elements, touching: &touching };
    let mut crowd = Crowd::new(mechanism)?;
    if decision(crowd.held_at(scene, state, STEP)?) <= least {
        return None;
    }
    let mut response = Response::new(mechanism);
    let mut forces = |at: &State, accelerations: &mut [f64], efforts: &mut [f64]| {
        efforts.fill(0.0);
        for motor in elements.motors.iter().filter(|motor| !has_row(motor)) {
            let place = motor.coordinate;
            let position = at.position[place.position] + at.compensation[place.position];
            efforts[place.freedom] += motor.bounded(motor.effort(at.time, position, at.velocity[place.freedom]));
        }
        response.accelerations(at, efforts, accelerations);
    };
    let mut after = state.clone();
    crowd.step(scene, &mut forces, &mut after, STEP, true)?;
    let mut points = Vec::new();
    crowd.pressing(&touching, &mut points);
    Some(points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use nalgebra::Vector3;

    #[test]
    fn a_step_over_events_tells_the_forces_at_rest_that_the_problem_of_accelerations_does() {
        // Three cubes of 2 kg on each other: 2 g, 4 g and 6 g between them and on the floor.
        let body = |_| {
            let joint = Joint::new("box", JointKind::Floating, Pose::identity(), Pose::identity());
            Body { name: "box".into(), parent: None, mass: 2.0, inertia: Vector3::repeat(0.02 / 1.5), joint }
        };
        let mut stack = Mechanism::new("stack", Vector3::z() * -9.81, (0..3).map(body).collect()).expect("free bodies");
        let half = Vector3::repeat(0.1);
        let nonsmooth = &mut stack.nonsmooth;
        nonsmooth.colliders.push(Collider::still("floor", None, Pose::identity(), Shape::HalfSpace));
        for body in 0..3 {
            nonsmooth.colliders.push(Collider::still("box", Some(body), Pose::identity(), Shape::Box { half }));
            nonsmooth.pairs.push(ContactPair::without_moments(body, [body, body + 1], 0.5, 0.0));
        }
        let mut state = State::zero(&stack);
        (0..3).for_each(|body| state.position[7 * body + 2] = 0.1 + 0.2 * body as f64);
        let sums = |points: &[ContactPoint]| {
            let of = |pair: usize| points.iter().filter(move |point| point.pair == pair);
            [0, 1, 2].map(|pair| of(pair).map(|point| point.force.z.abs()).sum::<f64>())
        };
        let (stepped, solved) = (by_step(&stack, &state, 0.0).expect("a step"), Exerted::contacts(&stack, &state));
        for (pair, (stepped, solved)) in sums(&stepped).into_iter().zip(sums(&solved)).enumerate() {
            let weight = 2.0 * 9.81 * (3 - pair) as f64;
            assert!((stepped - weight).abs() < 1e-8 && (solved - weight).abs() < 1e-8, "{stepped} {solved}");
        }
        assert!(by_step(&stack, &state, CHEAP).is_none());
    }

    #[test]
    fn a_hundred_closed_contacts_are_told_by_a_step_over_events() {
        // 25 cubes of 2 kg in a row, 0.3 m apart: each has its own four contacts.
        let body = |_| {
            let joint = Joint::new("box", JointKind::Floating, Pose::identity(), Pose::identity());
            Body { name: "box".into(), parent: None, mass: 2.0, inertia: Vector3::repeat(0.02 / 1.5), joint }
        };
        let mut row = Mechanism::new("row", Vector3::z() * -9.81, (0..25).map(body).collect()).expect("free bodies");
        let half = Vector3::repeat(0.1);
        row.nonsmooth.colliders.push(Collider::still("floor", None, Pose::identity(), Shape::HalfSpace));
        let mut state = State::zero(&row);
        for body in 0..25 {
            let collider = Collider::still("box", Some(body), Pose::identity(), Shape::Box { half });
            row.nonsmooth.colliders.push(collider);
            row.nonsmooth.pairs.push(ContactPair::without_moments(body, [0, body + 1], 0.5, 0.0));
            (state.position[7 * body], state.position[7 * body + 2]) = (0.3 * body as f64, 0.1);
        }
        let points = by_step(&row, &state, CHEAP).expect("many contacts");
        let weight = points.iter().map(|point| point.force.z.abs()).sum::<f64>();
        assert!(points.len() == 100 && (weight - 25.0 * 2.0 * 9.81).abs() < 1e-7, "{} {weight}", points.len());
    }
}

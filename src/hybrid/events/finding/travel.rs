//! How far bodies travel, as bounds of the changes of gaps over many steps.
//!
//! ```text
//!     D_i += V_i h                      V_i (m/s): the fastest point of body i within its reach, seen from a carrier
//!     φ_ab(t) ≥ φ_ab(t₁) − (D_a(t) − D_a(t₁)) − (D_b(t) − D_b(t₁))
//!     M   += 2 max_i V_i h              no gap falls by more than M does
//! ```
//!
//! D_i and M are lengths (m), h is the length of a step (s); [`crate::events::finding::speeds`] has V. Distances are the same seen from any rigid
//! body: the carrier of two bodies of one robot is the first body of its tree, because bodies of a robot that walks are slow beside each other. The
//! carrier of all other pairs is the world. A body that is moved between two steps has travelled by the displacement of its farthest point,
//! `|Δc| + |ΔR| R`.
//!
//! Sums are rounded upwards. Source: B. Mirtich, Impulse-based Dynamic Simulation, PhD thesis, Berkeley 1996, chapter 2.

use crate::events::finding::speeds::Speeds;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;

/// A body whose travel is summed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Traveller {
    pub body: usize,
    /// The carrier from which it is seen; `None` is the world.
    pub carrier: Option<usize>,
    /// The largest distance of its shapes from its centre of mass (m).
    pub reach: f64,
}

/// The travel of all bodies up to the start of the step in question, and up to its end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Travel {
    travellers: Vec<Traveller>,
    /// Their numbers by body and carrier.
    numbers: BTreeMap<(usize, Option<usize>), usize>,
    start: Travelled,
    end: Travelled,
    /// Whether a step has begun.
    known: bool,
}

/// The travel up to one instant.
#[derive(Clone, Debug, Default)]
struct Travelled {
    /// All bodies there.
    bodies: Vec<BodyState>,
    /// D of each traveller, and M (m).
    sums: Vec<f64>,
    most: f64,
}

impl Travel {
    /// The number of a traveller, which is added if it is new; its reach is the largest of those that were given.
    pub fn traveller(&mut self, body: usize, carrier: Option<usize>, reach: f64) -> usize {
        let next = self.travellers.len();
        let index = *self.numbers.entry((body, carrier)).or_insert(next);
        if index == next {
            self.travellers.push(Traveller { body, carrier, reach });
            self.start.sums.push(0.0);
            self.end.sums.push(0.0);
        }
        let known = &mut self.travellers[index];
        known.reach = known.reach.max(reach);
        index
    }

    /// Whether the step before counts, for a step that begins with the bodies at these places. It does not if the same step is looked at again.
    /// The start is then its end.
    pub fn counts(&mut self, at: &[BodyState]) -> bool {
        if !self.known {
            self.known = true;
            self.start.bodies = at.to_vec();
            self.end.bodies = at.to_vec();
            return true;
        }
        let again = !are_there(&self.end.bodies, at) && are_there(&self.start.bodies, at);
        if !again {
            std::mem::swap(&mut self.start, &mut self.end);
        }
        !again
    }

    /// Moves the bodies to these places where the step begins, if they are elsewhere.
    pub fn move_to(&mut self, at: &[BodyState]) {
        let Travelled { bodies, sums, most } = &mut self.start;
        if !are_there(bodies, at) {
            let moved = self.travellers.iter().map(|traveller| displacement(traveller, bodies, at));
            add(sums, most, moved);
            bodies.copy_from_slice(at);
        }
    }

    /// The step of these speeds and length (s), from the places that were taken last.
    pub fn go_on(&mut self, speeds: &Speeds, length: f64) {
        let Travelled { bodies, sums, most } = &mut self.end;
        bodies.copy_from_slice(speeds.last());
        sums.copy_from_slice(&self.start.sums);
        *most = self.start.most;
        let moved = self
            .travellers
            .iter()
            .map(|&Traveller { body, carrier, reach }| length * speeds.seen_from(Some(body), carrier, reach));
        add(sums, most, moved);
    }

    /// D of two travellers together at the start and at the end of the step (m).
    pub fn of(&self, pair: [Option<usize>; 2]) -> [f64; 2] {
        let sum = |travelled: &Travelled| pair.iter().flatten().map(|&index| travelled.sums[index]).sum();
        [sum(&self.start), sum(&self.end)]
    }

    /// M at the start and at the end of the step (m); not finite where a speed is not.
    pub fn most(&self) -> [f64; 2] {
        [self.start.most, self.end.most]
    }
}

/// Adds what each traveller has moved by (m).
fn add(sums: &mut [f64], most: &mut f64, moved: impl Iterator<Item = f64>) {
    let upwards = |sum: f64| sum * (1.0 + f64::EPSILON);
    let mut largest = 0.0;
    for (sum, moved) in sums.iter_mut().zip(moved) {
        *sum = upwards(*sum + moved);
        // A speed that is not a number shall not be lost.
        largest = if moved <= largest || largest.is_nan() { largest } else { moved };
    }
    *most = upwards(*most + 2.0 * largest);
}

/// Whether bodies are at these places, to the last bit.
fn are_there(bodies: &[BodyState], at: &[BodyState]) -> bool {
    bodies.iter().zip(at).all(|(body, at)| body.position == at.position && body.rotation == at.rotation)
}

/// The most that a point of a traveller is moved by between two placements of all bodies, seen from its carrier (m).
fn displacement(traveller: &Traveller, before: &[BodyState], after: &[BodyState]) -> f64 {
    let &Traveller { body, carrier, reach } = traveller;
    let [(c0, r0), (c1, r1)] =
        [before, after].map(|all| seen_from(&all[body], carrier.map_or(&WORLD, |carrier| &all[carrier])));
    let turned = (r1 - r0).norm();
    (c1 - c0).norm() + if turned > 0.0 { turned * reach } else { 0.0 }
}

/// The place of a body in the axes of a carrier.
fn seen_from(body: &BodyState, carrier: &BodyState) -> (Vector3<f64>, Matrix3<f64>) {
    let axes = carrier.rotation.transpose();
    (axes * (body.position - carrier.position), axes * body.rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::finding::detection::SAMPLES;
    use nalgebra::Rotation3;

    /// A carrier that flies and turns, and a body that turns about an axis of it at ω (rad/s), 0.3 m beside it, at a time (s).
    fn flight(time: f64, turning: f64) -> [BodyState; 2] {
        let spin = Vector3::new(0.3, -0.5, 0.7);
        let rotation = Rotation3::new(spin * time).into_inner();
        let velocity = Vector3::new(4.0, 1.0, -2.0);
        let carrier = BodyState { position: velocity * time, rotation, velocity, angular_velocity: spin };
        let apart = rotation * Vector3::new(0.0, 0.3, 0.0);
        let own = Vector3::new(0.0, 0.0, turning);
        let body = BodyState {
            position: carrier.position + apart,
            rotation: rotation * Rotation3::new(own * time).into_inner(),
            velocity: velocity + spin.cross(&apart),
            angular_velocity: spin + rotation * own,
        };
        [carrier, body]
    }

    fn step(travel: &mut Travel, [from, to]: [f64; 2], turning: f64) -> bool {
        let mut speeds = Speeds::default();
        speeds.reset(2);
        speeds.take(0, &flight(from, turning));
        speeds.take(SAMPLES, &flight(to, turning));
        let counts = travel.counts(speeds.first());
        travel.move_to(speeds.first());
        travel.go_on(&speeds, to - from);
        counts
    }

    #[test]
    fn a_body_that_turns_beside_its_carrier_travels_as_it_turns_however_fast_both_fly() {
        let mut travel = Travel::default();
        let (beside, flying) = (travel.traveller(1, Some(0), 0.2), travel.traveller(1, None, 0.2));
        for count in 0..100 {
            let time = 1e-3 * f64::from(count);
            assert!(step(&mut travel, [time, time + 1e-3], 0.5));
        }
        // A quarter more than ω R t, and half of the changes of ω, which turns with the carrier: 0.9 rad/s in steps of 1 ms.
        let [_, by] = travel.of([Some(beside), None]);
        let turned = 1.25 * 0.5 * 0.2 * 0.1;
        assert!(by >= turned && by < turned * (1.0 + 1e-3), "{by}");
        let [_, by] = travel.of([None, Some(flying)]);
        assert!(by > 0.1 * 21.0_f64.sqrt(), "{by}");
        // M falls as fast as the gap of two bodies like the fastest.
        assert!((travel.most()[1] - 2.0 * by).abs() < 1e-9);
    }

    #[test]
    fn a_step_that_is_looked_at_again_counts_once_and_a_body_that_is_moved_has_travelled() {
        let mut travel = Travel::default();
        let beside = travel.traveller(1, Some(0), 0.2);
        step(&mut travel, [0.0, 1e-3], 0.5);
        let [_, once] = travel.of([Some(beside), None]);
        for _ in 0..3 {
            assert!(!step(&mut travel, [0.0, 1e-3], 0.5));
        }
        assert_eq!(travel.of([Some(beside), None]), [0.0, once]);
        // Moved by 2 s of its turn, while no step was looked at: 1 rad, whose chord is at most √2 rad times R in the norm of a matrix.
        assert!(step(&mut travel, [2.001, 2.002], 0.5));
        let [start, _] = travel.of([Some(beside), None]);
        let chord = 2.0 * 0.5_f64.sin() * 2.0_f64.sqrt() * 0.2;
        assert!((start - once - chord).abs() < 1e-6, "{start} {chord}");
    }

    #[test]
    fn a_speed_that_is_not_a_number_is_seen_in_the_most() {
        let (mut sums, mut most) = (vec![0.0; 3], 0.0);
        add(&mut sums, &mut most, [1.0, f64::NAN, 0.5].into_iter());
        assert!(most.is_nan());
    }
}

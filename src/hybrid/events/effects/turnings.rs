//! The turnings of contacts at an event, against rolling and spinning friction: which of them come to rest.
//!
//! ```text
//!     at rest:   L |ω_T| ≤ rest  of rolling,   L |ω_n| ≤ rest  of spinning;   1e4 times as much of one whose stop was found
//! ```
//!
//! with the arm L of the pair (m) and the speed of rest of slips [m/s].

use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::Scene;
use crate::events::modes::tolerances::STOPPED_SLIP;
use crate::instant::holding::blocks::{Row, row_of_torque};
use crate::instant::holding::moments::Turning;
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::touches::{tangents, touch_motion};
use nalgebra::Vector3;

impl Contacts {
    /// How a contact, by its number, turns against rolling and spinning friction: zero for a part that is at rest, or that it has no friction against.
    /// The turnings of this list stop.
    pub(super) fn turning_above_rest(
        &self,
        scene: &Scene,
        bodies: &[BodyState],
        index: usize,
        halts: &[(usize, bool)],
    ) -> Turning {
        let rest =
            |spinning: bool| if self.is_among(index, spinning, halts) { STOPPED_SLIP * self.rest } else { self.rest };
        turning_faster(scene, bodies, &self.all[index], [rest(false), rest(true)])
    }

    /// Whether a contact, by its number, is in a list of closed contacts that turn.
    pub(super) fn is_among(&self, index: usize, spinning: bool, list: &[(usize, bool)]) -> bool {
        self.known[index].is_some_and(|known| list.contains(&(known, spinning)))
    }

    /// The rows of the turnings of a contact, by its number, that rest, where there is friction against them.
    pub(super) fn rows_of_rest(
        &self,
        scene: &Scene,
        bodies: &[BodyState],
        index: usize,
        turning: &Turning,
    ) -> Vec<Row> {
        let contact = &self.all[index];
        let lengths = &scene.touching.pairs[contact.pair].moments;
        if lengths.are_zero() {
            return Vec::new();
        }
        let normal = touch_motion(&contact.joint, bodies).normal;
        let mut rows = Vec::new();
        let mut rest = |along: &Vector3<f64>| rows.push(row_of_torque(scene.whole, bodies, &contact.joint, along));
        if lengths.rolling > 0.0 && turning.across == Vector3::zeros() {
            tangents(&normal).iter().for_each(&mut rest);
        }
        if lengths.spinning > 0.0 && turning.along == 0.0 {
            rest(&normal);
        }
        rows
    }
}

/// How a contact turns against rolling and spinning friction, each faster than a rest [m/s] at the arm of the pair.
pub(super) fn turning_faster(scene: &Scene, bodies: &[BodyState], contact: &Contact, rests: [f64; 2]) -> Turning {
    let of = &scene.touching.pairs[contact.pair];
    if of.moments.are_zero() {
        return Turning::default();
    }
    let Turning { across, along } = Turning::of(&contact.joint, bodies, &touch_motion(&contact.joint, bodies).normal);
    let turns = |speed: f64, rest: f64, length: f64| length > 0.0 && of.arm() * speed > rest;
    Turning {
        across: if turns(across.norm(), rests[0], of.moments.rolling) { across } else { Vector3::zeros() },
        along: if turns(along.abs(), rests[1], of.moments.spinning) { along } else { 0.0 },
    }
}

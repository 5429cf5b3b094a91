//! Contacts on seams: faces of fixed obstacles that lie side by side in one plane are one surface for a body.
//!
//! ```text
//!     shared:   p_c in the hull of the points of the body's shape on another obstacle, with the same normal and the same laws
//!     corner:   p_c outside the hull of the other points of the shape on this plane
//! ```
//!
//! p_c (m): place of a contact c. One obstacle in place of them would have contacts at the corners of the part of the plane that both share, and only
//! there. So a shared contact that is no corner is left out, and of several at one corner one stays: the one of the obstacle onto which the corner
//! moves. A wheel that stands on two tiles has the two ends of its line of contact, one on each tile, without points on the seam between them.

use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::Scene;
use crate::events::modes::mode::Mode;
use crate::geometry::FeatureId;
use crate::instant::holding::pairs::Pair;
use crate::instant::holding::touching::{Contact, Touching};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{tangents, touch_motion};
use nalgebra::{Rotation3, Vector3};
use std::collections::BTreeMap;

/// Points this near to each other along the plane are at one place, and to the hull of others in it, relative to the larger shape.
const SAME_PLACE: f64 = 1e-10;
/// The same across the plane: contacts that are looked for anew have gaps of 1e-9.
const SAME_PLANE: f64 = 1e-8;
/// The same for shared contacts, relative to the smaller shape: a line of contact that is nearly along a seam passes it this far behind its end, which is
/// 1.2e-11 beyond it, and a round shape of radius r with a gap g touches the edge before it at √(2 g r).
const SHARED: f64 = 2e-5;
/// Normals whose tangential parts differ by more than this belong to different planes. Over such an edge the normal is off by √(2 g/r).
const SAME_NORMAL: f64 = 1e-4;
/// A body moves by this part of the size of a pair to tell onto which obstacle it does.
const AHEAD: f64 = 1e-6;
/// How much farther inside its borders a point must then be than another, relative to the same size.
const FARTHER: f64 = 1e-9;

/// A contact of a shape with a fixed obstacle.
struct Placed<'c> {
    number: usize,
    contact: &'c Contact,
    point: Vector3<f64>,
    /// Away from the obstacle.
    normal: Vector3<f64>,
    /// Its pair.
    of: &'c Pair,
}

/// The collider of a moving body in a pair with a fixed obstacle.
pub(super) fn shape_on_obstacle(touching: &Touching, pair: usize) -> Option<usize> {
    let [a, b] = touching.pairs.colliders_of(pair);
    match touching.pairs.bodies_of(pair) {
        [None, Some(_)] => Some(b),
        [Some(_), None] => Some(a),
        _ => None,
    }
}

impl<'c> Placed<'c> {
    fn new(touching: &'c Touching, number: usize, contact: &'c Contact, bodies: &[BodyState]) -> Self {
        let motion = touch_motion(&contact.joint, bodies);
        let outwards = if contact.joint.a.body.is_none() { motion.normal } else { -motion.normal };
        Placed { number, contact, point: motion.point, normal: outwards, of: &touching.pairs[contact.pair] }
    }

    /// Whether another one is on the same plane, under the same laws.
    fn is_beside(&self, other: &Placed) -> bool {
        let across = self.normal.dot(&(other.point - self.point));
        across.abs() <= self.of.within(SAME_PLANE)
            && (other.normal - self.normal).norm() <= SAME_NORMAL
            && self.of.has_laws_of(other.of)
    }

    /// Whether it is in the hull of others of its plane, or this near to it (m).
    fn is_among<'o>(&self, others: impl Iterator<Item = &'o Placed<'o>>, within: f64) -> bool {
        let [first, second] = tangents(&self.normal);
        let from_here = |other: &Placed| {
            let to = other.point - self.point;
            [first.dot(&to), second.dot(&to)]
        };
        is_in_hull(&others.map(from_here).collect::<Vec<_>>(), within)
    }

    /// How far another one is along the plane (m).
    fn to(&self, other: &Placed) -> f64 {
        let to = other.point - self.point;
        (to - self.normal * self.normal.dot(&to)).norm()
    }

    /// Points this near are at its place (m).
    fn here(&self) -> f64 {
        self.of.within(SAME_PLACE)
    }

    /// Shared contacts are this near to the points of the other obstacle (m).
    fn nearby(&self) -> f64 {
        self.here().max(SHARED * self.of.arm())
    }

    /// A contact this near to the hull of others is no corner (m). A round shape touches edges beside the place where it stands.
    fn inside(&self) -> f64 {
        let is_round = self.of.revolved.iter().any(Option::is_some);
        if is_round && !self.is_on_face() { self.nearby() } else { self.here() }
    }

    /// Whether the contact is on a face of the obstacle, at a corner of the shape.
    fn is_on_face(&self) -> bool {
        let on_b = (self.contact.joint.a.body.is_none()) == self.contact.is_swapped();
        let obstacle = if on_b { self.contact.features.b } else { self.contact.features.a };
        matches!(obstacle, FeatureId::Face(_) | FeatureId::Cap(_))
    }

    /// How far inside its borders it is after a small motion of its body (m).
    fn margin_ahead(&self, touching: &Touching, bodies: &[BodyState]) -> f64 {
        let size = self.of.size();
        let reach = self.of.reach.into_iter().filter(|reach| reach.is_finite()).fold(0.0, f64::max);
        let mut moved = bodies.to_vec();
        for body in self.of.bodies.into_iter().flatten() {
            let body = &mut moved[body];
            let time = AHEAD * size / (body.velocity.norm() + reach * body.angular_velocity.norm());
            if time.is_finite() {
                body.position += body.velocity * time;
                body.rotation = Rotation3::new(body.angular_velocity * time).into_inner() * body.rotation;
            }
        }
        touching.margin(self.contact, &moved)
    }
}

impl Contacts {
    /// Takes the contacts of other pairs, too, whose obstacles continue the planes of these, which have been looked for in the order of their numbers.
    pub(super) fn take_flush(
        &mut self,
        scene: &Scene,
        before: &Mode,
        mut sought: Vec<usize>,
        within: impl Fn(usize) -> f64,
        bodies: &[BodyState],
    ) {
        let touching = scene.touching;
        let shape_of = |&pair: &usize| shape_on_obstacle(touching, pair);
        let mut near_of: BTreeMap<usize, Vec<usize>> =
            sought.iter().filter_map(shape_of).map(|shape| (shape, Vec::new())).collect();
        for pair in scene.near.iter().filter(|pair| sought.binary_search(pair).is_err()) {
            if let Some(near) = shape_of(pair).and_then(|shape| near_of.get_mut(&shape)) {
                near.push(*pair);
            }
        }
        let mut next = 0;
        while let Some(&pair) = sought.get(next) {
            next += 1;
            let laws = |other: usize| touching.pairs[pair].has_laws_of(&touching.pairs[other]);
            let others = shape_of(&pair).and_then(|shape| near_of.get_mut(&shape));
            let Some(others) = others.filter(|others| !others.is_empty()) else { continue };
            let own: Vec<Contact> = self.all.iter().filter(|contact| contact.pair == pair).cloned().collect();
            if own.is_empty() || own.iter().any(|contact| contact.flat_end().is_some()) {
                continue;
            }
            others.retain(|&other| {
                let near = if laws(other) { touching.near(other, bodies, within(other)) } else { Vec::new() };
                let near: Vec<Contact> = near.into_iter().map(|(contact, _)| contact).collect();
                let is_flush = are_flush(touching, &own, &near, bodies);
                if is_flush {
                    let is_of_other: Vec<bool> = self.all.iter().map(|contact| contact.pair == other).collect();
                    self.take_out(|number| is_of_other[number]);
                    self.take_near(scene, before, other, near, &[], bodies);
                    sought.push(other);
                }
                !is_flush
            });
        }
    }

    /// Leaves out the contacts on seams, but for those before this number.
    pub(super) fn leave_out_seams(&mut self, touching: &Touching, bodies: &[BodyState], first: usize) {
        let mut shapes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (number, contact) in self.all.iter().enumerate() {
            if let Some(shape) = shape_on_obstacle(touching, contact.pair) {
                shapes.entry(shape).or_default().push(number);
            }
        }
        let (mut left_out, mut handed) = (Vec::new(), Vec::new());
        for own in shapes.into_values() {
            let of = |number: usize| &self.all[number];
            // Flat ends choose their points in other ways.
            let one_pair = own.iter().all(|&number| of(number).pair == of(own[0]).pair);
            if one_pair || own.iter().any(|&number| of(number).flat_end().is_some()) {
                continue;
            }
            let placed: Vec<Placed> =
                own.iter().map(|&number| Placed::new(touching, number, of(number), bodies)).collect();
            let mut shared: Vec<&Placed> = placed.iter().filter(|one| is_shared(one, &placed)).collect();
            shared.sort_by_key(|one| one.is_on_face());
            let beside = |one: &Placed| placed.iter().filter(|other| one.is_beside(other)).collect::<Vec<_>>();
            for one in &shared {
                let stays = |other: &&Placed| !left_out.contains(&other.number);
                if !stays(one) {
                    continue;
                }
                let here = shared.iter().copied().filter(stays);
                let here = here.filter(|other| one.is_beside(other) && one.to(other) <= one.here());
                let here: Vec<&Placed> = here.collect();
                let kept = self.that_stays(&here, first, touching, bodies);
                let others = here.iter().map(|other| other.number);
                let others: Vec<usize> = others.filter(|&number| number != kept.number && number >= first).collect();
                handed.extend(others.iter().map(|&number| (number, kept.number)));
                left_out.extend(others);
                let rest = beside(kept).into_iter();
                let rest = rest.filter(|other| other.number != kept.number && !left_out.contains(&other.number));
                if kept.number >= first && kept.is_among(rest, kept.inside()) {
                    left_out.push(kept.number);
                }
            }
        }
        // A corner that goes from one obstacle to the next goes on as it was.
        for (from, to) in handed {
            self.known[to] = self.known[to].or(self.known[from]);
        }
        self.seams.extend(left_out.iter().map(|&number| self.all[number].clone()));
        self.take_out(|number| left_out.contains(&number));
    }

    /// The contact that stays of these at one place: a corner of the shape on a face, on the face onto which it moves, one that was
    /// closed.
    fn that_stays<'p>(
        &self,
        here: &[&'p Placed<'p>],
        first: usize,
        touching: &Touching,
        bodies: &[BodyState],
    ) -> &'p Placed<'p> {
        let mut best = here[0];
        let mut margin = f64::NAN;
        for &other in &here[1..] {
            if best.number < first {
                break;
            }
            let better = match (other.is_on_face(), best.is_on_face()) {
                (true, true) => {
                    let farther = FARTHER * best.of.size();
                    margin = if margin.is_nan() { best.margin_ahead(touching, bodies) } else { margin };
                    let ahead = other.margin_ahead(touching, bodies);
                    let is_known = |of: &Placed| self.known[of.number].is_some();
                    let known = is_known(other) && !is_known(best);
                    let better = ahead > margin + farther || (known && ahead >= margin - farther);
                    margin = if better { ahead } else { margin };
                    better
                }
                (on_face, is) => {
                    margin = if on_face && !is { f64::NAN } else { margin };
                    on_face && !is
                }
            };
            best = if better { other } else { best };
        }
        best
    }
}

/// The contacts among these, left out on seams, that the closed contacts of a mode keep where they are: they are in the hull of closed ones of their plane.
pub(super) fn held_seams(scene: &Scene, state: &State, seams: &[Contact], mode: &Mode) -> Vec<Contact> {
    if seams.is_empty() {
        return Vec::new();
    }
    let (touching, bodies) = (scene.touching, body_states(scene.whole, state));
    let closed: Vec<Placed> = mode
        .contacts
        .iter()
        .map(|closed| &closed.contact)
        .filter(|contact| shape_on_obstacle(touching, contact.pair).is_some())
        .map(|contact| Placed::new(touching, 0, contact, &bodies))
        .collect();
    let is_held = |seam: &&Contact| {
        let (shape, seam) = (shape_on_obstacle(touching, seam.pair), Placed::new(touching, 0, seam, &bodies));
        let own = |one: &&Placed| shape_on_obstacle(touching, one.contact.pair) == shape;
        seam.is_among(closed.iter().filter(own).filter(|one| seam.is_beside(one)), seam.inside())
    };
    seams.iter().filter(is_held).cloned().collect()
}

/// Whether a contact is also on another obstacle of its plane.
fn is_shared(one: &Placed, all: &[Placed]) -> bool {
    let mut others: BTreeMap<usize, Vec<&Placed>> = BTreeMap::new();
    for other in all.iter().filter(|other| other.contact.pair != one.contact.pair && one.is_beside(other)) {
        others.entry(other.contact.pair).or_default().push(other);
    }
    others.values().any(|of| one.is_among(of.iter().copied(), one.nearby()))
}

/// Whether contacts of two pairs of a shape share a place on one plane.
fn are_flush(touching: &Touching, own: &[Contact], near: &[Contact], bodies: &[BodyState]) -> bool {
    if near.is_empty() || near.iter().any(|contact| contact.flat_end().is_some()) {
        return false;
    }
    let all = own.iter().chain(near).map(|contact| Placed::new(touching, 0, contact, bodies));
    let all: Vec<Placed> = all.collect();
    all.iter().any(|one| is_shared(one, &all))
}

/// Whether the origin is in the convex hull of points, or this near to it: the nearest point of all lines between two of them is the nearest of the hull
/// if the origin is outside, and then no point is behind the origin.
fn is_in_hull(points: &[[f64; 2]], within: f64) -> bool {
    let mut nearest = ([0.0; 2], f64::INFINITY);
    for (index, &[x, y]) in points.iter().enumerate() {
        for &[to_x, to_y] in &points[index..] {
            let along = [to_x - x, to_y - y];
            let length = along[0].hypot(along[1]);
            let part =
                if length > 0.0 { (-(x * along[0] + y * along[1]) / (length * length)).clamp(0.0, 1.0) } else { 0.0 };
            let at = [x + part * along[0], y + part * along[1]];
            if at[0].hypot(at[1]) < nearest.1 {
                nearest = (at, at[0].hypot(at[1]));
            }
        }
    }
    let (towards, distance) = nearest;
    distance <= within || points.iter().any(|[x, y]| towards[0] * x + towards[1] * y < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_in_the_hull_of_others_or_is_a_corner_beside_them() {
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let about = |x: f64, y: f64| square.map(|[of_x, of_y]| [of_x - x, of_y - y]);
        assert!(is_in_hull(&about(0.2, -0.7), 1e-10), "inside");
        assert!(is_in_hull(&about(0.2, -1.0), 1e-10), "on a side");
        assert!(is_in_hull(&about(1.0, -1.0), 1e-10), "at a corner");
        assert!(!is_in_hull(&about(0.2, -1.0 - 1e-9), 1e-10), "beyond a side");
        assert!(!is_in_hull(&about(1.3, 1.2), 1e-10), "beyond a corner");
        assert!(is_in_hull(&[[-1.0, 0.0], [2.0, 0.0]], 1e-10), "on a line");
        assert!(!is_in_hull(&[[1.0, 0.0], [2.0, 0.0]], 1e-10), "beyond the end of a line");
        assert!(!is_in_hull(&[], 1e-10), "no points");
    }
}

//! The pairs of colliders that may touch: their geometry, and their contacts in a given state.
//!
//! A pair is asked for its distance while it is open, and for its contacts, pairs of features, where it is nearly closed. A pose belongs
//! to a body; the world has its own.

use crate::geometry::{Before, Distance, FeatureId, PlaceId, TouchPlace};
use crate::instant::holding::pairs::{Pair, Pairs};
use crate::instant::holding::rope::ROUNDED;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::contact::{Grip, Moments, Touch, TouchJoint};
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::touches::{TouchMotion, touch_motion};
use nalgebra::{Rotation3, Translation3, Vector3};

/// Features this near to each other, relative to the size of their pair, touch.
pub(crate) const TOUCHED: f64 = 1e-11;
/// A feature touches no farther beyond its border than this part of the size of the pair.
const BEYOND: f64 = 1e-9;
/// Other features of a pair that touches are looked for within these parts of the distance that is asked for.
const SEARCHED: [f64; 3] = [1.0 / 64.0, 1.0 / 8.0, 1.0];
/// Shapes whose gap is more than this part of the smaller one are well apart.
const WELL_APART: f64 = 1e-3;

/// The pairs of a mechanism.
#[derive(Clone, Default)]
pub(crate) struct Touching {
    pub pairs: Pairs,
}

/// One contact of a pair.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Which pair.
    pub pair: usize,
    /// Which features of it.
    pub features: PlaceId,
    /// The features and their frames; it rolls unless it is said otherwise.
    pub joint: TouchJoint,
    /// The features as the geometry knows them.
    place: TouchPlace,
}

impl Contact {
    /// Whether it is between the same features of the same pair as another one.
    pub fn is_at(&self, other: &Contact) -> bool {
        self.pair == other.pair && self.features == other.features
    }

    /// Whether the first body of the joint belongs to the second collider of the pair.
    pub fn is_swapped(&self) -> bool {
        self.place.swapped
    }

    /// The flat end of a cylinder at whose rim this contact has a point, if there is one.
    pub fn flat_end(&self) -> Option<RimOf> {
        let (of_second, end) = match (self.features.a, self.features.b) {
            (FeatureId::RimPoint { end, .. }, _) => (false, end),
            (_, FeatureId::RimPoint { end, .. }) => (true, end),
            _ => return None,
        };
        Some(RimOf { pair: self.pair, of_second, end })
    }

    /// The rim on a plane that touches, or of which a point touches.
    fn rim(&self) -> Option<RimOf> {
        use FeatureId::{Cap, Face, Rim, RimPoint};
        let (of_second, end) = match (self.features.a, self.features.b) {
            (Rim(end) | RimPoint { end, .. }, Face(_) | Cap(_)) => (false, end),
            (Face(_) | Cap(_), Rim(end) | RimPoint { end, .. }) => (true, end),
            _ => return None,
        };
        Some(RimOf { pair: self.pair, of_second, end })
    }
}

/// The rim of an end of a cylinder in a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RimOf {
    /// The pair.
    pub pair: usize,
    /// Whether the cylinder is the second collider of the pair.
    pub of_second: bool,
    /// 0 or 1.
    pub end: u32,
}

impl Touching {
    /// A contact in a state as reports name it, by the colliders of its pair, with the force on the second body of its joint (N).
    pub fn reported(
        &self,
        contact: &Contact,
        touch: &TouchMotion,
        on_second: &Vector3<f64>,
        sticks: bool,
    ) -> ContactPoint {
        let sign = if contact.is_swapped() { 1.0 } else { -1.0 };
        ContactPoint {
            pair: self.pairs[contact.pair].number,
            position: touch.point,
            normal: touch.normal * sign,
            force: on_second * sign,
            gap: touch.gap,
            sticks,
        }
    }

    /// The pairs of a mechanism. Pairs of impossible shapes are left out; the reader of a scene refuses them.
    pub fn new(mechanism: &Mechanism) -> Self {
        Touching { pairs: Pairs::new(mechanism) }
    }

    /// The distance of a pair (m); negative where it overlaps.
    pub fn distance(&self, pair: usize, bodies: &[BodyState]) -> f64 {
        let rope = self.pairs[pair].rope.as_ref();
        rope.map_or_else(|| self.nearest(pair, bodies).distance, |rope| rope.gap(bodies))
    }

    /// The distance of the shapes of a pair, with the points that have it.
    pub fn nearest(&self, pair: usize, bodies: &[BodyState]) -> Distance {
        let Pair { geometry, bodies: [a, b], .. } = &self.pairs[pair];
        geometry.distance(&pose(*a, bodies), &pose(*b, bodies))
    }

    /// The distance of a pair (m) if it may be at most `within` (m), otherwise a lower bound that is larger than `within`.
    pub fn distance_within(&self, pair: usize, bodies: &[BodyState], within: f64) -> f64 {
        let least = self.least_distance(pair, bodies, within);
        if least > within { least } else { self.distance(pair, bodies) }
    }

    /// Whether a pair overlaps by more than a depth (m).
    pub fn overlaps(&self, pair: usize, bodies: &[BodyState], depth: f64) -> bool {
        self.distance_within(pair, bodies, 0.0) < -depth
    }

    /// The distance of a pair (m) for a search of roots; of dense hulls that are well apart a lower bound, which GJK gives to its tolerance, and of hulls that
    /// overlap far a lower bound, too.
    pub fn gap(&self, pair: usize, bodies: &[BodyState]) -> f64 {
        let Pair { geometry, extents, bodies: [a, b], rope, .. } = &self.pairs[pair];
        if geometry.is_dense() {
            let least = self.least_distance(pair, bodies, f64::INFINITY);
            if least > WELL_APART * extents.smaller {
                return least;
            }
        }
        match rope {
            Some(rope) => rope.gap(bodies),
            None => geometry.distance_unless_deep(&pose(*a, bodies), &pose(*b, bodies)),
        }
    }

    /// A lower bound of the distance of a pair (m) for little work, and for a little more if the first one is at most `enough` (m).
    pub fn least_distance(&self, pair: usize, bodies: &[BodyState], enough: f64) -> f64 {
        let Pair { geometry, bodies: [a, b], rope, .. } = &self.pairs[pair];
        if let Some(rope) = rope {
            return rope.gap(bodies) - ROUNDED * rope.length;
        }
        geometry.least_distance(&pose(*a, bodies), &pose(*b, bodies), enough)
    }

    /// The contacts of a pair with a gap of at most `within` (m), and their gaps.
    pub fn near(&self, pair: usize, bodies: &[BodyState], within: f64) -> Vec<(Contact, f64)> {
        if self.least_distance(pair, bodies, within) > within {
            return Vec::new();
        }
        let Pair { geometry, bodies: of, rope, .. } = &self.pairs[pair];
        if let Some(rope) = rope {
            let gap = rope.gap(bodies);
            return if gap < within { vec![(self.contact(pair, rope.place.clone()), gap)] } else { Vec::new() };
        }
        self.with_gaps(pair, geometry.touches(&pose(of[0], bodies), &pose(of[1], bodies), within))
    }

    /// The same, but of two hulls with many vertices a few contacts, the nearest or deepest among them.
    pub fn a_few_near(&self, pair: usize, bodies: &[BodyState], within: f64) -> Vec<(Contact, f64)> {
        let Pair { geometry, bodies: of, .. } = &self.pairs[pair];
        if !geometry.is_dense() {
            return self.near(pair, bodies, within);
        }
        let before = &mut Before::default();
        let (places, _) = geometry.touches_soon(&pose(of[0], bodies), &pose(of[1], bodies), within, before);
        self.with_gaps(pair, places)
    }

    /// Contacts of a pair at these places, each with its gap (m).
    fn with_gaps(&self, pair: usize, places: Vec<TouchPlace>) -> Vec<(Contact, f64)> {
        let contacts = places.into_iter().map(|place| (place.gap, place));
        contacts.map(|(gap, place)| (self.contact(pair, place), gap)).collect()
    }

    /// The contacts of a pair that meets, along the normal along which it approaches slowest, if several separate it: at an edge on an edge, where the
    /// distance has one of them by roundings. Bodies that slide over a joint of two plates meet no edge. `found` are those along the normal of the
    /// distance, with a gap of at most `within` (m); along others the distance is the same to `alike` (m). Slower than `rest` is no approach [m/s].
    pub fn slowest(
        &self,
        pair: usize,
        bodies: &[BodyState],
        [alike, within]: [f64; 2],
        found: Vec<Contact>,
        rest: f64,
    ) -> Vec<Contact> {
        let Pair { geometry, bodies: [a, b], rope, .. } = &self.pairs[pair];
        let motion = |contact: &Contact| touch_motion(&contact.joint, bodies);
        let rate = |of: &[Contact]| of.iter().map(|contact| motion(contact).rate).fold(f64::INFINITY, f64::min);
        if rope.is_some() || found.is_empty() || rate(&found) >= -rest {
            return found;
        }
        let others = geometry.touches_otherwise(&pose(*a, bodies), &pose(*b, bodies), alike, within).into_iter();
        let others = others.map(|places| places.into_iter().map(|place| self.contact(pair, place)).collect());
        let mut best = (rate(&found), found);
        for other in others.collect::<Vec<Vec<Contact>>>() {
            let own = rate(&other);
            if own > best.0 + rest {
                best = (own, other);
            }
        }
        best.1
    }

    /// The contacts of a pair with a gap of at most `within` (m) in a quicker way, perhaps under other names. If there are none, a lower bound of
    /// the distance (m) where it is known. `before` is the knowledge of a moment ago.
    pub fn soon(&self, pair: usize, bodies: &[BodyState], within: f64, before: &mut Before) -> (Vec<Contact>, f64) {
        let Pair { geometry, bodies: of, rope, .. } = &self.pairs[pair];
        if rope.is_some() {
            let near = self.near(pair, bodies, within);
            before.touches = !near.is_empty();
            return (near.into_iter().map(|(contact, _)| contact).collect(), self.distance(pair, bodies));
        }
        let (places, apart) = geometry.touches_soon(&pose(of[0], bodies), &pose(of[1], bodies), within, before);
        (places.into_iter().map(|place| self.contact(pair, place)).collect(), apart)
    }

    /// The contact at the point of the same rim towards a direction in the world, if this contact is of a rim on a plane, or of a point of the rim.
    pub fn on_rim(&self, known: &Contact, towards: &Vector3<f64>, bodies: &[BodyState]) -> Option<Contact> {
        let Pair { geometry, bodies: of, .. } = &self.pairs[known.pair];
        let place = geometry.rim_place(&known.place, towards, &pose(of[0], bodies), &pose(of[1], bodies))?;
        Some(self.contact(known.pair, place))
    }

    /// The contact at the point of the same rim at a part of a turn from this one, and its gap (m), if this one is at a point of a rim on a plane.
    pub fn turned(&self, known: &Contact, part: f64, bodies: &[BodyState]) -> Option<(Contact, f64)> {
        known.rim()?;
        let Pair { geometry, bodies: of, .. } = &self.pairs[known.pair];
        let place = geometry.turned_place(&known.place, part, &pose(of[0], bodies), &pose(of[1], bodies))?;
        let gap = place.gap;
        Some((self.contact(known.pair, place), gap))
    }

    /// How far from overlapping the rest of a pair is that is closed at these contacts (m): as far as `within`, and on tangent planes as far as the pair is
    /// large.
    pub fn beside(&self, closed: &[&Contact], within: f64, bodies: &[BodyState]) -> f64 {
        let Some(first) = closed.first() else { return within };
        let pair = first.pair;
        let Pair { geometry, bodies: [a, b], .. } = &self.pairs[pair];
        let (a, b) = (pose(*a, bodies), pose(*b, bodies));
        let features: Vec<PlaceId> = closed.iter().map(|contact| contact.features).collect();
        if let Some(height) = geometry.lowest_beside(&features, &a, &b) {
            return height.min(within);
        }
        let far = self.pairs[pair].size();
        let mut least = far;
        for contact in closed {
            let TouchMotion { normal, point, .. } = touch_motion(&contact.joint, bodies);
            let normal = if contact.is_swapped() { -normal } else { normal };
            match geometry.beyond(&contact.features, &features, [&normal, &point], [&a, &b], far) {
                Some(height) => least = least.min(height),
                None => {
                    if let Some(least) = geometry.ball_beside(&features, &a, &b, within) {
                        return least;
                    }
                    // If a rim touches at one point alone, the opposite point is next: the cylinder tilts in a plane.
                    let points = closed.iter().filter(|contact| contact.flat_end().is_some());
                    let ends: Vec<RimOf> = points.clone().filter_map(|contact| contact.rim()).collect();
                    let alone = |end: &RimOf| ends.iter().filter(|other| *other == end).count() == 1;
                    let pivots = points.filter(|contact| contact.rim().is_some_and(|end| alone(&end)));
                    let opposite = pivots.filter_map(|contact| Some(self.turned(contact, 0.5, bodies)?.1));
                    // A search in a wide neighbourhood finds places beyond the borders of faces, too: a rim over an edge is below the plane of the face. Rounded
                    // shapes are as near there as the place says.
                    let border = if geometry.is_rounded() { f64::INFINITY } else { self.pairs[pair].within(BEYOND) };
                    let is_other = |(near, _): &&(Contact, f64)| {
                        let known = features.contains(&near.features) || near.rim().is_some_and(|end| alone(&end));
                        !known && self.margin(near, bodies) >= -border
                    };
                    let least = opposite.fold(within, f64::min);
                    // A search nearby finds fewer places to look at.
                    let of = |part: &f64| {
                        let near = self.near(pair, bodies, part * within);
                        near.iter().filter(is_other).map(|(_, gap)| *gap).min_by(f64::total_cmp)
                    };
                    return SEARCHED.iter().find_map(of).map_or(least, |gap| gap.min(least));
                }
            }
        }
        least
    }

    /// The angle (rad) up to which a pair may turn about its closed vertices on a half space before anything else of it touches, at least; `None` for
    /// other shapes and contacts.
    pub fn turns_at_least<'c>(
        &self,
        pair: usize,
        closed: impl Iterator<Item = &'c Contact> + Clone,
        bodies: &[BodyState],
    ) -> Option<f64> {
        let Pair { geometry, bodies: [a, b], rope, .. } = &self.pairs[pair];
        let places = closed.map(|contact| contact.features);
        let on_vertices = rope.is_none() && places.clone().next().is_some();
        on_vertices.then(|| geometry.turns_at_least(places, &pose(*a, bodies), &pose(*b, bodies))).flatten()
    }

    /// How far inside its features a contact is; negative where others are nearer.
    pub fn margin(&self, contact: &Contact, bodies: &[BodyState]) -> f64 {
        let Pair { geometry, bodies: [a, b], .. } = &self.pairs[contact.pair];
        geometry.margin(&contact.place, &pose(*a, bodies), &pose(*b, bodies))
    }

    /// The contact of a pair at a place.
    fn contact(&self, pair: usize, place: TouchPlace) -> Contact {
        let Pair { bodies, surfaces, rope, .. } = &self.pairs[pair];
        let touch = Touch { features: place.features, side: place.side, grip: Grip::Rolls };
        let swapped = usize::from(place.swapped);
        let [a, b] = [0, 1].map(|side: usize| {
            let (own, frame) = (side ^ swapped, place.frames[side]);
            (Attachment { body: bodies[own], frame }, frame.rotation.inverse() * surfaces[own])
        });
        let reeved = rope.as_ref().map_or(Vec::new(), |rope| rope.points.clone());
        let joint = TouchJoint { touch, a: a.0, b: b.0, surfaces: [a.1, b.1], moments: Moments::default(), reeved };
        Contact { pair, features: place.identity, joint, place }
    }
}

/// The pose of a body, or of the world.
fn pose(body: Option<usize>, bodies: &[BodyState]) -> Pose {
    let state = body.map_or(&WORLD, |body| &bodies[body]);
    Pose::from_parts(Translation3::from(state.position), Rotation3::from_matrix_unchecked(state.rotation))
}

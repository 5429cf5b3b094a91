//! The pairs of a mechanism that may touch, each prepared when it is first asked for.
//!
//! A thousand balls have half a million pairs, and a few thousand of them ever come near. A pair is known by its number in the list of all;
//! [`crate::instant::holding::near`] says which of them are to be asked.

use crate::geometry::{Extents, PairGeometry, PreparedShape, Revolved};
use crate::instant::holding::rolling::Rolling;
use crate::instant::holding::rope::{Part, Rope};
use crate::instant::holding::sparse::{Sparse, seconds};
use crate::mechanism::description::contact::{Collider, ContactPair, MomentLengths, Shape};
use crate::mechanism::description::contact_pairs::{ContactPairs, PairRun};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Reeving;
use nalgebra::Vector3;
use std::ops::Index;
use std::sync::OnceLock;

/// Pairs of one page.
const PAGE: usize = 32;
/// Gaps up to this part of the smaller shape, and of the larger one, are closed in a state without a known mode.
const TOUCHED_ANEW: f64 = 1e-9;
const TOUCHED: f64 = 1e-11;

/// Two colliders that may touch.
#[derive(Clone)]
pub(crate) struct Pair {
    pub(super) geometry: PairGeometry,
    /// The bodies that they are fixed in.
    pub bodies: [Option<usize>; 2],
    /// The velocities of their surfaces over the bodies, in the axes of the bodies or of the world [m/s].
    pub(super) surfaces: [Vector3<f64>; 2],
    /// The largest distance of each from the centre of mass of its body (m); infinite for a half space.
    pub reach: [f64; 2],
    /// The bodies and reaches whose speeds together bound the rate of the gap: its own, or all parts of a rope through several points.
    pub parts: Vec<Part>,
    /// The shapes of revolution among the two.
    pub revolved: [Option<Revolved>; 2],
    /// The round shape on a plane of the world that it is, if it is one.
    pub rolling: Option<Rolling>,
    /// The rope through several points that it is, if it is one.
    pub(super) rope: Option<Rope>,
    /// μ and e.
    pub friction: f64,
    pub restitution: f64,
    /// ρ and σ.
    pub moments: MomentLengths,
    /// Its number in the whole mechanism.
    pub number: usize,
    /// The lengths from which its tolerances are made.
    pub extents: Extents,
    /// How far a body moves at least while it passes through the other (m).
    pub breadth: f64,
}

impl Pair {
    /// Whether it is a rope through several points.
    pub fn is_reeved(&self) -> bool {
        self.rope.is_some()
    }

    /// The bodies whose motions change its gap: its own, or those of all parts of a rope.
    pub fn all_bodies(&self) -> impl Iterator<Item = Option<usize>> + '_ {
        self.parts.iter().flat_map(|(bodies, _)| *bodies)
    }

    /// The tolerance that is this part of its size (m).
    pub fn within(&self, part: f64) -> f64 {
        self.extents.within(part)
    }

    /// The arm by which a turning counts as a speed of its smaller shape (m).
    pub fn arm(&self) -> f64 {
        self.extents.smaller
    }

    /// Whether one of its shapes is a hull with many vertices.
    pub fn is_dense(&self) -> bool {
        self.geometry.is_dense()
    }

    /// Whether friction, restitution and the motions of surfaces are those of another pair of the same shape.
    pub fn has_laws_of(&self, other: &Pair) -> bool {
        let moves = |pair: &Pair| pair.surfaces.iter().any(|surface| *surface != Vector3::zeros());
        let same_motion = self.surfaces == other.surfaces && self.bodies == other.bodies;
        self.friction == other.friction
            && self.restitution == other.restitution
            && self.moments == other.moments
            && !self.is_reeved()
            && !other.is_reeved()
            && (same_motion || !(moves(self) || moves(other)))
    }

    /// Whether its shapes have one pair of features at most.
    pub fn has_one_place(&self) -> bool {
        self.geometry.has_one_place()
    }

    /// How far the larger of its two shapes extends (m).
    pub fn size(&self) -> f64 {
        self.extents.whole
    }

    /// Gaps up to this are closed in a state without a known mode (m): at the beginning of a run, and after steps of first order.
    pub fn closed_anew(&self) -> f64 {
        (TOUCHED_ANEW * self.extents.smaller).max(self.within(TOUCHED))
    }
}

/// A collider of a mechanism.
#[derive(Clone)]
struct Sided {
    body: Option<usize>,
    shape: PreparedShape,
    /// Its reach, if it is bounded and convex (m).
    reach: Option<f64>,
    surface: Vector3<f64>,
}

/// Some pairs that follow each other.
type Page = Box<[OnceLock<Box<Pair>>; PAGE]>;

/// All pairs by their numbers.
#[derive(Clone, Default)]
pub(crate) struct Pairs {
    /// The colliders that belong to pairs.
    sides: Vec<Sided>,
    given: ContactPairs,
    pages: Vec<OnceLock<Page>>,
    /// The ropes through several points, with their lengths (m).
    ropes: Vec<(Reeving, f64)>,
    /// Whether steps over events leave something out.
    need_events: bool,
    /// Which pairs can be left out; `None` if all are few.
    pub(super) sparse: Option<Sparse>,
}

impl Pairs {
    /// The pairs of a mechanism. Pairs of impossible shapes are left out; the reader of a scene refuses them.
    pub fn new(mechanism: &Mechanism) -> Self {
        let nonsmooth = &mechanism.nonsmooth;
        let colliders = if nonsmooth.pairs.is_empty() { &[] } else { nonsmooth.colliders.as_slice() };
        let shapes: Vec<_> = colliders.iter().map(PreparedShape::new).collect();
        let possible = |pair: &ContactPair| match (&shapes[pair.a], &shapes[pair.b]) {
            (Ok(a), Ok(b)) => a.may_touch(b).is_ok(),
            _ => false,
        };
        let mut given = nonsmooth.pairs.clone();
        // Shapes that touch everything of their kind need not be asked for each pair.
        let plain = |side: usize| shapes[side].as_ref().is_ok_and(PreparedShape::is_plain);
        let unusual: Vec<usize> = (0..shapes.len()).filter(|&side| !plain(side)).collect();
        let all_possible = |run: &PairRun| {
            let are_plain = plain(run.first.a) && seconds(&unusual, run).is_empty();
            are_plain || run.pairs().all(|pair| possible(&pair))
        };
        if !given.runs().iter().all(all_possible) {
            given.retain_mut(|pair| possible(pair));
        }
        let sided = |(shape, collider): (Result<PreparedShape, _>, &Collider)| {
            let shape = shape.unwrap_or_else(|_| PreparedShape::stand_in(collider));
            Sided { body: collider.body, reach: shape.reach(), shape, surface: collider.surface_velocity }
        };
        let sides = shapes.into_iter().zip(colliders).map(sided).collect();
        let ropes = nonsmooth.reevings.iter().filter_map(|rope| match nonsmooth.colliders[rope.collider].shape {
            Shape::Hollow { radius: length } => Some((rope.clone(), length)),
            _ => None,
        });
        let ropes: Vec<(Reeving, f64)> = ropes.collect();
        let need_events = !ropes.is_empty() || given.runs().iter().any(|run| !run.first.moments.are_zero());
        let pages = (0..given.len().div_ceil(PAGE)).map(|_| OnceLock::new()).collect();
        let mut pairs = Pairs { sides, given, pages, ropes, need_events, sparse: None };
        let colliders = pairs.sides.iter().map(|side| (side.body, side.reach));
        pairs.sparse = Sparse::new(mechanism, &pairs.given, colliders);
        pairs
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.given.len()
    }

    /// Whether nothing may touch.
    pub fn is_empty(&self) -> bool {
        self.given.is_empty()
    }

    /// Whether steps over events leave something out: rolling and spinning friction, and ropes through several points.
    pub fn need_events(&self) -> bool {
        self.need_events
    }

    /// Whether they are few, so that none is left out.
    pub fn are_few(&self) -> bool {
        self.sparse.is_none()
    }

    /// The largest reach of the shapes of a body that can be left out (m).
    pub fn reach_of(&self, body: usize) -> f64 {
        self.sparse.as_ref().and_then(|sparse| sparse.reach_of(body)).unwrap_or(0.0)
    }

    /// The bodies of a pair.
    pub fn bodies_of(&self, number: usize) -> [Option<usize>; 2] {
        let pair = self.given.at(number);
        [pair.a, pair.b].map(|side| self.sides[side].body)
    }

    /// The colliders of a pair, by their numbers in the mechanism.
    pub fn colliders_of(&self, number: usize) -> [usize; 2] {
        let pair = self.given.at(number);
        [pair.a, pair.b]
    }

    fn prepare(&self, number: usize) -> Pair {
        let ContactPair { friction, restitution, moments, number, a, b } = self.given.at(number);
        let rope = self.ropes.iter().find(|(rope, _)| rope.collider == a);
        let [a, b] = [a, b].map(|side| &self.sides[side]);
        let geometry = PairGeometry::of(&a.shape, &b.shape);
        let rope = rope.and_then(|(rope, length)| Rope::new(&rope.points, *length, &geometry));
        let (bodies, reach) = ([a.body, b.body], geometry.reach());
        Pair {
            bodies,
            surfaces: [a.surface, b.surface],
            parts: rope.as_ref().map_or_else(|| vec![(bodies, geometry.closing_reach())], Rope::parts),
            reach,
            revolved: geometry.revolved(),
            rolling: Rolling::of(bodies, &geometry),
            rope,
            extents: geometry.extents(),
            breadth: geometry.breadth(),
            geometry,
            friction,
            restitution,
            moments,
            number,
        }
    }

    /// How many have been asked for.
    #[cfg(test)]
    pub fn prepared(&self) -> usize {
        let pages = self.pages.iter().filter_map(|page| page.get());
        pages.map(|page| page.iter().filter(|pair| pair.get().is_some()).count()).sum()
    }
}

impl Index<usize> for Pairs {
    type Output = Pair;

    fn index(&self, number: usize) -> &Pair {
        let page = self.pages[number / PAGE].get_or_init(|| Box::new([const { OnceLock::new() }; PAGE]));
        page[number % PAGE].get_or_init(|| Box::new(self.prepare(number)))
    }
}

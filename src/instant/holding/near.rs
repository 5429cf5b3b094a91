//! The pairs that may be near: those of bodies whose homes overlap. All others are proved apart.
//!
//! ```text
//!     home of a body:    ball(c, R + s)        c: where it was when it got its home (m), R: reach of its shapes, s: how far it may move (m)
//!     at home:           |x − c| + m ≤ s       m: how far it moves in what follows, or how far apart pairs are to be told (m)
//!     left out:          |c_a − c_b| > R_a + s_a + R_b + s_b    ⇒    gap of each pair of a and b > m_a + m_b,  while both are at home
//! ```
//!
//! A body that is not at home gets a new home around itself, and the pairs with all bodies whose homes overlap with it are added, so that storage and
//! work are in proportion to the pairs that have been near. Only pairs of bounded convex shapes of two robots are left out. Pairs with the world
//! and of one robot are few, and always there.
//!
//! Homes are compared by a sweep along the axis along which they are spread most. Scenes with few pairs have all of them.
//!
//! Source: D. Baraff, Dynamic Simulation of Non-Penetrating Rigid Bodies, PhD thesis, Cornell 1992, section 2.4 (sweep along an axis); L. Verlet,
//! Computer "experiments" on classical fluids I, Physical Review 159 (1967) (lists of neighbours with a margin).

use crate::instant::holding::pairs::Pairs;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::ContactPair;
use crate::mechanism::description::mechanism::Mechanism;
use nalgebra::Vector3;

/// Scenes with fewer pairs have all of them.
const FEW: usize = 1000;
/// A new home lets a body move by this part of its reach, by this multiple of its margin, and by its speed for this time (s).
const OF_REACH: f64 = 0.25;
const OF_MARGIN: f64 = 1.5;
const AHEAD: f64 = 0.02;
/// Homes are larger by this part of the coordinates, for roundings.
const ROUNDED: f64 = 1e-12;
/// Up to this part of all bodies that have left their homes are compared one by one.
const ONE_BY_ONE: usize = 16;

/// Which pairs can be left out: constant data of a scene.
#[derive(Clone, Default)]
pub(crate) struct Sparse {
    /// R of each body (m); `None` for bodies without bounded convex shapes.
    reach: Vec<Option<f64>>,
    /// The first body of the robot of each body.
    roots: Vec<usize>,
    /// The colliders of each body that can be left out.
    colliders: Vec<Vec<usize>>,
    /// Where the pairs of each collider with later ones begin in the list of all.
    rows: Vec<usize>,
    /// The pairs that are always there.
    always: Vec<usize>,
}

/// The pairs that may be near, in the order of their numbers.
#[derive(Clone, Default)]
pub(crate) struct Near {
    pairs: Vec<usize>,
    /// c and s of each body; empty before the first look.
    homes: Vec<(Vector3<f64>, f64)>,
    known: bool,
}

impl Sparse {
    /// For the pairs of a mechanism; `None` if there are few, or in no order.
    pub fn new(mechanism: &Mechanism, pairs: &Pairs) -> Option<Self> {
        let given = &pairs.given;
        let ascending = |two: &[ContactPair]| (two[0].a, two[0].b) < (two[1].a, two[1].b);
        if given.len() < FEW || !given.windows(2).all(ascending) {
            return None;
        }
        let bodies = mechanism.bodies.len();
        let mut sparse = Sparse { reach: vec![None; bodies], colliders: vec![Vec::new(); bodies], ..Sparse::default() };
        for (index, body) in mechanism.bodies.iter().enumerate() {
            sparse.roots.push(body.parent.map_or(index, |parent| sparse.roots[parent]));
        }
        for (collider, side) in pairs.sides.iter().enumerate() {
            if let (Some(body), Some(reach)) = (side.body, side.reach) {
                sparse.reach[body] = Some(sparse.reach[body].map_or(reach, |known| known.max(reach)));
                sparse.colliders[body].push(collider);
            }
        }
        let mut first = 0;
        for collider in 0..=pairs.sides.len() {
            first += given[first..].partition_point(|pair| pair.a < collider);
            sparse.rows.push(first);
        }
        sparse.always = (0..given.len()).filter(|&pair| sparse.apart(pairs, pair).is_none()).collect();
        // Nothing is gained if most pairs are always there.
        (2 * sparse.always.len() < given.len()).then_some(sparse)
    }

    pub fn reach_of(&self, body: usize) -> Option<f64> {
        self.reach[body]
    }

    /// The bodies of a pair that can be left out.
    fn apart(&self, pairs: &Pairs, pair: usize) -> Option<[usize; 2]> {
        let ContactPair { a, b, .. } = pairs.given[pair];
        let [one, other] = [a, b].map(|side| &pairs.sides[side]);
        let (Some(of_a), Some(of_b)) = (one.body, other.body) else { return None };
        let bounded = one.reach.is_some() && other.reach.is_some();
        (bounded && self.roots[of_a] != self.roots[of_b]).then_some([of_a, of_b])
    }

    /// Adds the numbers of the pairs of two bodies.
    fn add(&self, pairs: &Pairs, [a, b]: [usize; 2], out: &mut Vec<usize>) {
        if self.roots[a] == self.roots[b] {
            return;
        }
        for &one in &self.colliders[a] {
            for &other in &self.colliders[b] {
                let (first, second) = (one.min(other), one.max(other));
                let row = self.rows[first]..self.rows[first + 1];
                let found = pairs.given[row.clone()].binary_search_by_key(&second, |pair| pair.b);
                out.extend(found.ok().map(|place| row.start + place));
            }
        }
    }
}

impl Near {
    /// The pairs.
    pub fn pairs(&self) -> &[usize] {
        &self.pairs
    }

    /// The pairs that may be nearer than the margins (m) of their bodies together, in a state.
    pub fn within(pairs: &Pairs, bodies: &[BodyState], margin: impl Fn(usize) -> f64) -> Self {
        let mut near = Near::default();
        near.see(pairs, bodies, margin);
        near
    }

    /// Sees the bodies at their places, with margins (m): adds pairs until all others are farther apart than their margins together. Says whether
    /// there are new ones.
    pub fn see(&mut self, all: &Pairs, bodies: &[BodyState], margin: impl Fn(usize) -> f64) -> bool {
        let Some(sparse) = &all.sparse else {
            let new = !self.known;
            if new {
                self.pairs = (0..all.len()).collect();
                self.known = true;
            }
            return new && !self.pairs.is_empty();
        };
        if !self.known {
            self.pairs.clone_from(&sparse.always);
            self.homes = vec![(Vector3::zeros(), f64::NEG_INFINITY); bodies.len()];
        }
        let mut moved = Vec::new();
        for (body, state) in bodies.iter().enumerate() {
            let Some(reach) = sparse.reach[body] else { continue };
            let (centre, slack) = self.homes[body];
            let margin = margin(body);
            let is_home = (state.position - centre).norm() + margin <= slack;
            if !is_home {
                let room = OF_REACH * reach + OF_MARGIN * margin + AHEAD * state.velocity.norm();
                self.homes[body] = (state.position, room);
                moved.push(body);
            }
        }
        if moved.is_empty() {
            return false;
        }
        let mut found = Vec::new();
        self.compare(sparse, &moved, |pair| sparse.add(all, pair, &mut found));
        let before = self.pairs.len();
        self.pairs.append(&mut found);
        self.pairs.sort_unstable();
        self.pairs.dedup();
        !std::mem::replace(&mut self.known, true) || self.pairs.len() > before
    }

    /// Leaves out pairs of bodies whose homes no longer overlap; says which pairs stay, if some do not.
    pub fn leave_out(&mut self, all: &Pairs) -> bool {
        let Some(sparse) = all.sparse.as_ref().filter(|_| self.known) else { return false };
        let homes = &self.homes;
        let before = self.pairs.len();
        self.pairs.retain(|&pair| sparse.apart(all, pair).is_none_or(|of| overlap(sparse, homes, of)));
        self.pairs.len() < before
    }

    /// Whether two bodies of a pair that is not among these are at home with these margins (m), and their homes apart: the certificate of the pair.
    pub fn proves_apart(&self, all: &Pairs, pair: usize, bodies: &[BodyState], margin: impl Fn(usize) -> f64) -> bool {
        let Some(sparse) = &all.sparse else { return false };
        let at_home = |body: usize| {
            let (centre, slack) = self.homes[body];
            (bodies[body].position - centre).norm() + margin(body) <= slack
        };
        sparse.apart(all, pair).is_some_and(|of| of.into_iter().all(at_home) && !overlap(sparse, &self.homes, of))
    }

    /// Calls a function with the bodies whose homes overlap with those of `moved`, which ascend.
    fn compare(&self, sparse: &Sparse, moved: &[usize], mut found: impl FnMut([usize; 2])) {
        let count = self.homes.len();
        if ONE_BY_ONE * moved.len() <= count {
            for &one in moved {
                for other in (0..count).filter(|&other| other != one && overlap(sparse, &self.homes, [one, other])) {
                    found([one, other]);
                }
            }
            return;
        }
        let mut is_moved = vec![false; count];
        moved.iter().for_each(|&body| is_moved[body] = true);
        let present = (0..count).filter(|&body| sparse.reach[body].is_some());
        let place = |body: usize, axis: usize| self.homes[body].0[axis];
        let spread = |axis: usize| {
            let places = present.clone().map(|body| place(body, axis));
            let (low, high) =
                places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
            high - low
        };
        let axis = (0..3).max_by(|&one, &other| spread(one).total_cmp(&spread(other))).unwrap_or(0);
        let half = |body: usize| size(sparse, &self.homes, body);
        let mut sorted: Vec<(f64, f64, usize)> = present
            .clone()
            .map(|body| (place(body, axis) - half(body), place(body, axis) + half(body), body))
            .map(|(low, high, body)| if low <= high { (low, high, body) } else { (f64::NEG_INFINITY, f64::INFINITY, body) })
            .collect();
        sorted.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (number, &(_, high, one)) in sorted.iter().enumerate() {
            for &(low, _, other) in &sorted[number + 1..] {
                if low > high {
                    break;
                }
                if (is_moved[one] || is_moved[other]) && overlap(sparse, &self.homes, [one, other]) {
                    found([one, other]);
                }
            }
        }
    }
}

/// R + s of a body, and a little more for roundings (m).
fn size(sparse: &Sparse, homes: &[(Vector3<f64>, f64)], body: usize) -> f64 {
    let (centre, slack) = homes[body];
    let size = sparse.reach[body].unwrap_or(0.0) + slack;
    size + ROUNDED * (size + centre.amax())
}

/// Whether two homes overlap, or may.
fn overlap(sparse: &Sparse, homes: &[(Vector3<f64>, f64)], [one, other]: [usize; 2]) -> bool {
    if sparse.reach[one].is_none() || sparse.reach[other].is_none() {
        return false;
    }
    let apart = (homes[one].0 - homes[other].0).norm();
    let is_apart = apart > size(sparse, homes, one) + size(sparse, homes, other);
    !is_apart
}

//! The pairs that may be near: their bodies have homes that overlap. All others are proved apart.
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
use crate::instant::holding::sparse::Sparse;
use crate::mechanism::description::body_state::BodyState;
use nalgebra::Vector3;

/// A new home lets a body move by this part of its reach, by this multiple of its margin, and by its speed for this time (s).
const OF_REACH: f64 = 0.25;
const OF_MARGIN: f64 = 1.5;
const AHEAD: f64 = 0.02;
/// Homes are larger by this part of the coordinates, for roundings.
const ROUNDED: f64 = 1e-12;
/// Up to this part of all bodies that have left their homes are compared one by one.
const ONE_BY_ONE: usize = 16;

/// The pairs that may be near, in the order of their numbers.
#[derive(Clone, Default)]
pub(crate) struct Near {
    pairs: Vec<usize>,
    /// c and s of each body; empty before the first look.
    homes: Vec<(Vector3<f64>, f64)>,
    known: bool,
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
            self.pairs = sparse.always().to_vec();
            self.homes = vec![(Vector3::zeros(), f64::NEG_INFINITY); bodies.len()];
        }
        let mut moved = Vec::new();
        for (body, state) in bodies.iter().enumerate() {
            let Some(reach) = sparse.reach_of(body) else { continue };
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
        self.compare(sparse, &moved, |pair| sparse.add(pair, &mut found));
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
        self.pairs.retain(|&pair| sparse.apart(pair).is_none_or(|of| overlap(sparse, homes, of)));
        self.pairs.len() < before
    }

    /// Whether two bodies of a pair that is not among these are at home with these margins (m), and their homes apart: the certificate of the pair.
    pub fn proves_apart(&self, all: &Pairs, pair: usize, bodies: &[BodyState], margin: impl Fn(usize) -> f64) -> bool {
        let Some(sparse) = &all.sparse else { return false };
        let at_home = |body: usize| {
            let (centre, slack) = self.homes[body];
            (bodies[body].position - centre).norm() + margin(body) <= slack
        };
        sparse.apart(pair).is_some_and(|of| of.into_iter().all(at_home) && !overlap(sparse, &self.homes, of))
    }

    /// Calls a function with each two bodies whose homes overlap, if one of them is among `moved`, which ascend.
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
        let present = (0..count).filter(|&body| sparse.reach_of(body).is_some());
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
            .map(
                |(low, high, body)| {
                    if low <= high { (low, high, body) } else { (f64::NEG_INFINITY, f64::INFINITY, body) }
                },
            )
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
    let size = sparse.reach_of(body).unwrap_or(0.0) + slack;
    size + ROUNDED * (size + centre.amax())
}

/// Whether two homes overlap, or may.
fn overlap(sparse: &Sparse, homes: &[(Vector3<f64>, f64)], [one, other]: [usize; 2]) -> bool {
    if sparse.reach_of(one).is_none() || sparse.reach_of(other).is_none() {
        return false;
    }
    let apart = (homes[one].0 - homes[other].0).norm();
    let is_apart = apart > size(sparse, homes, one) + size(sparse, homes, other);
    !is_apart
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::scenes::Random;
    use crate::mechanism::description::body_state::WORLD;
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::{Body, Mechanism};

    const RADIUS: f64 = 0.1;

    /// Free balls, and a floor: everything may touch everything.
    fn balls(count: usize) -> Pairs {
        let body = |_| {
            let joint = Joint::new("ball", JointKind::Floating, Pose::identity(), Pose::identity());
            Body { name: "ball".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(1.0), joint }
        };
        let bodies = (0..count).map(body).collect();
        let mut mechanism = Mechanism::new("balls", Vector3::zeros(), bodies).expect("free bodies");
        let nonsmooth = &mut mechanism.nonsmooth;
        for ball in 0..count {
            let shape = Shape::Sphere { radius: RADIUS };
            nonsmooth.colliders.push(Collider::still("ball", Some(ball), Pose::identity(), shape));
        }
        nonsmooth.colliders.push(Collider::still("floor", None, Pose::identity(), Shape::HalfSpace));
        for (a, b) in (0..count).flat_map(|a| (a + 1..=count).map(move |b| (a, b))) {
            let number = nonsmooth.pairs.len();
            nonsmooth.pairs.push(ContactPair::without_moments(number, [a, b], 0.5, 0.0));
        }
        Pairs::new(&mechanism)
    }

    fn at(position: Vector3<f64>, velocity: Vector3<f64>) -> BodyState {
        BodyState { position, velocity, ..WORLD }
    }

    #[test]
    fn pairs_that_are_left_out_are_farther_apart_than_their_margins_wherever_bodies_go() {
        let (count, mut random) = (60, Random::new(3));
        let pairs = balls(count);
        let mut near = Near::default();
        let mut any = || Vector3::new(random.signed(), random.signed(), random.signed());
        let mut bodies: Vec<BodyState> = (0..count).map(|_| at(any() * 2.0, any() * 3.0)).collect();
        let mut counts = [0, 0];
        for round in 0..400 {
            for (body, state) in bodies.iter_mut().enumerate() {
                // Now and then one is put elsewhere, and all are: a few are compared one by one, and many in a sweep.
                let jumps = round % 100 == 99 || (round % 7 == 0 && body == round % count);
                state.position = if jumps { any() * 2.0 } else { state.position + state.velocity * 0.003 };
            }
            let margin = |body: usize| 1e-3 * (1 + body % 50) as f64;
            near.see(&pairs, &bodies, margin);
            if round % 20 == 10 {
                near.leave_out(&pairs);
            }
            for pair in 0..pairs.len() {
                let is_near = near.pairs().binary_search(&pair).is_ok();
                let [Some(a), Some(b)] = pairs.bodies_of(pair) else {
                    assert!(is_near, "a pair with the floor is always there");
                    continue;
                };
                let gap = (bodies[a].position - bodies[b].position).norm() - 2.0 * RADIUS;
                counts[usize::from(is_near)] += 1;
                assert!(is_near || gap > margin(a) + margin(b), "round {round}: {a} and {b} are {gap} m apart");
                assert!(is_near || near.proves_apart(&pairs, pair, &bodies, margin), "round {round}: {a} and {b}");
            }
        }
        // Balls in 64 m³ whose homes reach 0.3 m at most: 1 % of the pairs are near.
        assert!(counts[1] * 3 < counts[0], "{counts:?} far and near");
    }

    #[test]
    fn a_body_that_is_not_at_home_is_no_certificate() {
        let pairs = balls(60);
        let mut bodies: Vec<BodyState> =
            (0..60).map(|ball| at(Vector3::x() * f64::from(ball), Vector3::zeros())).collect();
        let near = Near::within(&pairs, &bodies, |_| 0.0);
        // Balls 0 and 2, which are 2 m apart.
        assert!(near.proves_apart(&pairs, 1, &bodies, |_| 0.0));
        bodies[0].position.y = 0.03;
        assert!(!near.proves_apart(&pairs, 1, &bodies, |_| 0.0));
    }

    #[test]
    fn a_grid_of_balls_has_pairs_in_proportion_to_its_balls() {
        for side in [10, 20, 30] {
            let pairs = balls(side * side);
            let place = |ball: usize| Vector3::new(0.22 * (ball % side) as f64, 0.22 * (ball / side) as f64, 0.1);
            let bodies: Vec<BodyState> = (0..side * side).map(|ball| at(place(ball), Vector3::zeros())).collect();
            let near = Near::within(&pairs, &bodies, |_| 0.0);
            // One pair of each ball with the floor, and one of each two neighbours: homes of 0.125 m do not reach those across the corner, at 0.31 m.
            let wanted = side * side + 2 * side * (side - 1);
            assert_eq!(near.pairs().len(), wanted);
            near.pairs().iter().for_each(|&pair| assert!(pairs[pair].within(1.0) > 0.0));
            assert_eq!(pairs.prepared(), wanted);
        }
    }
}

//! The pairs of a scene that can be left out while their bodies are far apart: bounded convex shapes of two robots.
//!
//! Pairs with the world and of one robot are few, and always there.

use crate::mechanism::description::contact::ContactPair;
use crate::mechanism::description::contact_pairs::{ContactPairs, PairRun};
use crate::mechanism::description::mechanism::Mechanism;

/// Scenes with fewer pairs have all of them.
const FEW: usize = 1000;

/// Which pairs can be left out: constant data of a scene.
#[derive(Clone, Default)]
pub(crate) struct Sparse {
    /// R of each body (m); `None` for bodies without bounded convex shapes.
    reach: Vec<Option<f64>>,
    /// The first body of the robot of each body.
    roots: Vec<usize>,
    /// All pairs, and the bodies of colliders that are bounded and convex.
    given: ContactPairs,
    bounded: Vec<Option<usize>>,
    /// The colliders of each body that can be left out.
    colliders: Vec<Vec<usize>>,
    /// The pairs that are always there.
    always: Vec<usize>,
}

impl Sparse {
    /// For pairs of a mechanism and its colliders, each with its body and its reach if it is bounded and convex (m); `None` if there are few, or in no order.
    pub fn new(
        mechanism: &Mechanism,
        given: &ContactPairs,
        colliders: impl Iterator<Item = (Option<usize>, Option<f64>)>,
    ) -> Option<Self> {
        if given.len() < FEW || !given.are_in_order() {
            return None;
        }
        let bodies = mechanism.bodies.len();
        let (reach, own) = (vec![None; bodies], vec![Vec::new(); bodies]);
        let mut sparse = Sparse { given: given.clone(), reach, colliders: own, ..Sparse::default() };
        for (index, body) in mechanism.bodies.iter().enumerate() {
            sparse.roots.push(body.parent.map_or(index, |parent| sparse.roots[parent]));
        }
        for (collider, (body, reach)) in colliders.enumerate() {
            let bounded = body.zip(reach);
            sparse.bounded.push(bounded.map(|(body, _)| body));
            if let Some((body, reach)) = bounded {
                sparse.reach[body] = Some(sparse.reach[body].map_or(reach, |known| known.max(reach)));
                sparse.colliders[body].push(collider);
            }
        }
        sparse.always = sparse.never_left_out();
        // Nothing is gained if most pairs are always there.
        (2 * sparse.always.len() < given.len()).then_some(sparse)
    }

    /// The largest reach of the shapes of a body that can be left out (m).
    pub fn reach_of(&self, body: usize) -> Option<f64> {
        self.reach[body]
    }

    /// The pairs that are always there.
    pub fn always(&self) -> &[usize] {
        &self.always
    }

    /// The bodies of a pair that can be left out.
    pub fn apart(&self, pair: usize) -> Option<[usize; 2]> {
        let ContactPair { a, b, .. } = self.given.at(pair);
        let (one, other) = self.bounded[a].zip(self.bounded[b])?;
        (self.roots[one] != self.roots[other]).then_some([one, other])
    }

    /// The pairs of a collider that is not bounded, and of two of one robot.
    fn never_left_out(&self) -> Vec<usize> {
        let mut of_root = vec![Vec::new(); self.reach.len()];
        let mut unbounded = Vec::new();
        for (collider, body) in self.bounded.iter().enumerate() {
            match body {
                Some(body) => of_root[self.roots[*body]].push(collider),
                None => unbounded.push(collider),
            }
        }
        let (mut pairs, mut before) = (Vec::new(), 0);
        for run in self.given.runs() {
            match self.bounded[run.first.a] {
                Some(body) => {
                    let own = &of_root[self.roots[body]];
                    let others = seconds(&unbounded, run).iter().chain(seconds(own, run));
                    pairs.extend(others.map(|other| before + other - run.first.b));
                }
                None => pairs.extend(before..before + run.count),
            }
            before += run.count;
        }
        pairs.sort_unstable();
        pairs
    }

    /// Adds the numbers of the pairs of two bodies.
    pub fn add(&self, [a, b]: [usize; 2], out: &mut Vec<usize>) {
        if self.roots[a] == self.roots[b] {
            return;
        }
        for &one in &self.colliders[a] {
            for &other in &self.colliders[b] {
                out.extend(self.given.place_of(one.min(other), one.max(other)));
            }
        }
    }
}

/// Those of some colliders, which ascend, that are the second of a pair of a run.
pub(super) fn seconds<'c>(colliders: &'c [usize], run: &PairRun) -> &'c [usize] {
    let first = colliders.partition_point(|&collider| collider < run.first.b);
    let end = colliders.partition_point(|&collider| collider < run.first.b + run.count);
    &colliders[first..end]
}

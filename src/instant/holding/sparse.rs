//! The pairs of a scene that can be left out while their bodies are far apart: bounded convex shapes of two robots.
//!
//! Pairs with the world and of one robot are few, and always there.

use crate::mechanism::description::contact::ContactPair;
use crate::mechanism::description::contact_pairs::ContactPairs;
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
    /// Where the pairs of each collider with later ones begin in the list of all.
    rows: Vec<usize>,
    /// The pairs that are always there.
    always: Vec<usize>,
}

impl Sparse {
    /// For pairs of a mechanism and its colliders, each with its body and its reach if it is bounded and convex (m); `None` if there are few, or in no order.
    pub fn new(
        mechanism: &Mechanism,
        given: &ContactPairs,
        colliders: impl ExactSizeIterator<Item = (Option<usize>, Option<f64>)>,
    ) -> Option<Self> {
        let ascending = |two: &[ContactPair]| (two[0].a, two[0].b) < (two[1].a, two[1].b);
        let in_order = given.windows(2).all(ascending) && given.iter().all(|pair| pair.a < pair.b);
        if given.len() < FEW || !in_order {
            return None;
        }
        let bodies = mechanism.bodies.len();
        let (reach, own) = (vec![None; bodies], vec![Vec::new(); bodies]);
        let mut sparse = Sparse { given: given.clone(), reach, colliders: own, ..Sparse::default() };
        for (index, body) in mechanism.bodies.iter().enumerate() {
            sparse.roots.push(body.parent.map_or(index, |parent| sparse.roots[parent]));
        }
        let count = colliders.len();
        for (collider, (body, reach)) in colliders.enumerate() {
            let bounded = body.zip(reach);
            sparse.bounded.push(bounded.map(|(body, _)| body));
            if let Some((body, reach)) = bounded {
                sparse.reach[body] = Some(sparse.reach[body].map_or(reach, |known| known.max(reach)));
                sparse.colliders[body].push(collider);
            }
        }
        let mut first = 0;
        for collider in 0..=count {
            first += given[first..].partition_point(|pair| pair.a < collider);
            sparse.rows.push(first);
        }
        sparse.always = (0..given.len()).filter(|&pair| sparse.apart(pair).is_none()).collect();
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
        let ContactPair { a, b, .. } = self.given[pair];
        let (one, other) = self.bounded[a].zip(self.bounded[b])?;
        (self.roots[one] != self.roots[other]).then_some([one, other])
    }

    /// Adds the numbers of the pairs of two bodies.
    pub fn add(&self, [a, b]: [usize; 2], out: &mut Vec<usize>) {
        if self.roots[a] == self.roots[b] {
            return;
        }
        for &one in &self.colliders[a] {
            for &other in &self.colliders[b] {
                let (first, second) = (one.min(other), one.max(other));
                let row = self.rows[first]..self.rows[first + 1];
                let found = self.given[row.clone()].binary_search_by_key(&second, |pair| pair.b);
                out.extend(found.ok().map(|place| row.start + place));
            }
        }
    }
}

//! The names of the shapes of pairs that may touch, by the numbers of the pairs.

use crate::mechanism::description::contact_pairs::ContactPairs;
use crate::model::Model;

/// The pairs, and the names of all shapes.
pub(super) struct PairNames {
    pairs: ContactPairs,
    shapes: Vec<String>,
}

impl PairNames {
    /// Of a model.
    pub fn new(model: &Model) -> Self {
        let nonsmooth = &model.mechanism.nonsmooth;
        let shapes = nonsmooth.colliders.iter().map(|collider| collider.name.clone()).collect();
        PairNames { pairs: nonsmooth.pairs.clone(), shapes }
    }

    /// The names of the shapes of a pair; empty for a number that no pair has.
    pub fn of(&self, number: usize) -> [&str; 2] {
        let pair = self.pairs.with_number(number);
        pair.map_or([""; 2], |pair| [pair.a, pair.b].map(|shape| self.shapes[shape].as_str()))
    }
}

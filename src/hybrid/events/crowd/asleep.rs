//! The trees that sleep.

use crate::crowd::trees::Trees;

/// Which trees sleep, and in which group.
#[derive(Clone, Default)]
pub(crate) struct Asleep {
    /// The group of each tree that sleeps, by its first tree.
    pub(super) group: Vec<Option<usize>>,
    /// The tree of each body.
    pub(super) of_body: Vec<usize>,
}

impl Asleep {
    /// Trees that are all awake.
    pub fn new(trees: &Trees) -> Self {
        Asleep { group: vec![None; trees.trees.len()], of_body: trees.of_body.clone() }
    }

    /// Whether a tree sleeps.
    pub fn has(&self, tree: usize) -> bool {
        self.group[tree].is_some()
    }

    /// Whether a body sleeps, or is the world.
    pub fn holds(&self, body: Option<usize>) -> bool {
        body.is_none_or(|body| self.has(self.of_body[body]))
    }
}

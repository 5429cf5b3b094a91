//! The order in which a matrix of blocks is eliminated, and the places of its blocks: one node a tree, one edge for trees that touch each other.
//!
//! ```text
//!     least degree first:   the neighbours of the node that goes are joined with each other
//! ```
//!
//! Memory grows with the edges that there are and that elimination adds, not with the square of the nodes.

use std::collections::BTreeSet;

/// A later neighbour of a node: the first entries of both blocks of the pair.
#[derive(Clone, Copy, Debug)]
pub struct Later {
    pub node: usize,
    /// The block (own, later), right of the diagonal.
    pub right: usize,
    /// The block (later, own), below it.
    pub below: usize,
}

/// The order of elimination and the places of the blocks.
#[derive(Clone, Default)]
pub struct Pattern {
    /// Sizes of the blocks, and where their unknowns begin.
    pub sizes: Vec<usize>,
    pub offsets: Vec<usize>,
    pub(crate) order: Vec<usize>,
    /// The nodes after each that it is joined with, by their numbers.
    pub(crate) later: Vec<Vec<Later>>,
    pub(crate) diagonal: Vec<usize>,
    rank: Vec<usize>,
    /// The blocks that each pair of later neighbours changes, in the order of elimination.
    pub(crate) targets: Vec<usize>,
    pub(crate) total: usize,
}

impl Pattern {
    /// For blocks of these sizes, joined by edges.
    pub fn new(sizes: Vec<usize>, edges: &[(usize, usize)]) -> Self {
        let count = sizes.len();
        let mut offsets = Vec::with_capacity(count);
        let mut unknowns = 0;
        for &size in &sizes {
            offsets.push(unknowns);
            unknowns += size;
        }
        if count == 1 {
            let (later, total) = (vec![Vec::new()], unknowns * unknowns);
            let (order, diagonal, rank) = (vec![0], vec![0], vec![0]);
            return Pattern { sizes, offsets, order, later, diagonal, rank, targets: Vec::new(), total };
        }
        let mut joined: Vec<Vec<usize>> = vec![Vec::new(); count];
        for &(one, other) in edges.iter().filter(|(one, other)| one != other) {
            joined[one].push(other);
            joined[other].push(one);
        }
        for neighbours in &mut joined {
            neighbours.sort_unstable();
            neighbours.dedup();
        }
        let mut left: BTreeSet<(usize, usize)> = (0..count).map(|node| (joined[node].len(), node)).collect();
        let (mut order, mut rank) = (Vec::with_capacity(count), vec![0; count]);
        let mut merged = Vec::new();
        while let Some((_, node)) = left.pop_first() {
            rank[node] = order.len();
            order.push(node);
            let own = std::mem::take(&mut joined[node]);
            for &other in &own {
                left.remove(&(joined[other].len(), other));
                merged.clear();
                merged.extend(joined[other].iter().chain(&own).copied().filter(|&next| next != node && next != other));
                merged.sort_unstable();
                merged.dedup();
                joined[other].clone_from(&merged);
                left.insert((merged.len(), other));
            }
            joined[node] = own;
        }
        let (mut total, mut diagonal) = (0, vec![0; count]);
        let mut later = Vec::with_capacity(count);
        for (node, neighbours) in joined.into_iter().enumerate() {
            diagonal[node] = total;
            total += sizes[node] * sizes[node];
            let block = |other: usize| {
                let area = sizes[node] * sizes[other];
                total += 2 * area;
                Later { node: other, right: total - 2 * area, below: total - area }
            };
            later.push(neighbours.into_iter().map(block).collect::<Vec<_>>());
        }
        let mut pattern = Pattern { sizes, offsets, order, later, diagonal, rank, targets: Vec::new(), total };
        let mut targets = Vec::new();
        for &node in &pattern.order {
            for row in &pattern.later[node] {
                targets.extend(pattern.later[node].iter().map(|column| pattern.place(row.node, column.node)));
            }
        }
        pattern.targets = targets;
        pattern
    }

    /// The first entry of the block of two nodes that are the same or joined.
    pub fn place(&self, row: usize, column: usize) -> usize {
        if row == column {
            return self.diagonal[row];
        }
        let (first, last) = if self.rank[row] < self.rank[column] { (row, column) } else { (column, row) };
        let later = &self.later[first];
        let found = &later[later.partition_point(|later| later.node < last)];
        if first == row { found.right } else { found.below }
    }
}

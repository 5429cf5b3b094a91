//! The groups of equations between trees whose contacts slide, of which some may imply others ([`crate::coupled::dependent`]).
//!
//! ```text
//!     nodes: the trees that float, and the world with all trees on it        edges: pairs of trees that slide on each other, or that both float and touch
//!     edges on a circle with one that slides, joined by the trees that they share: one group.  Each other edge that slides: a group of its own
//! ```
//!
//! A block between a wall and the jaw of a vice: the pairs (world, block) and (jaw, block) are two edges between two nodes. Two cards that lean on each
//! other and slide on a floor: the edge between them sticks, and is on a circle with the others. What an edge on no circle carries from one side to the
//! other is determined, so that it shares no load with the rest. Beside a tree on the world, what sticks bears what normals do not
//! (`doc/decisions/033-friction-that-holds.md`).

use catena_mechanism::description::contact::TouchJoint;
use catena_mechanism::description::joint::JointKind;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::ground::disjoint_sets::DisjointSets;
use std::ops::Range;

/// The ends of an equation: trees, named by their first bodies, or bodies.
pub(crate) type Ends = [Option<usize>; 2];

/// The row of an equation, and the bodies at its ends.
pub(crate) type Between = (usize, Ends);

/// Equations between pairs of trees.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// The trees, in order.
    pub pairs: Vec<Ends>,
    pub rows: Vec<Between>,
}

/// The rows of contacts that a group has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rows {
    /// The gaps.
    Gaps,
    /// The gaps, and the slips and turnings that friction holds.
    All,
}

/// All groups of a mechanism in which contacts slide with friction, for the rows of its loops and then of its contacts.
pub(crate) fn sliding_groups(mechanism: &Mechanism, rows_of_closure: &[Range<usize>], rows_of: Rows) -> Vec<Group> {
    let mut found: Vec<Group> = Vec::new();
    let is_reeved = |number: usize| {
        number.checked_sub(mechanism.loops.len()).is_some_and(|touch| mechanism.touches[touch].is_reeved())
    };
    let closures = mechanism.closing_ends().zip(rows_of_closure).enumerate();
    for (number, ([a, b], rows)) in closures.filter(|(number, _)| !is_reeved(*number)) {
        let pair = trees_of(mechanism, [a.body, b.body]);
        // The first row of a contact is its gap; a rolling contact has more rows, of rates.
        let count = if number < mechanism.loops.len() || rows_of == Rows::All { rows.len() } else { 1 };
        let of_these = rows.clone().take(count).map(|row| (row, [a.body, b.body]));
        match found.iter_mut().find(|known| known.pairs == [pair]) {
            Some(known) => known.rows.extend(of_these),
            None => found.push(Group { pairs: vec![pair], rows: of_these.collect() }),
        }
    }
    let pair = |joint: &TouchJoint| trees_of(mechanism, [joint.a.body, joint.b.body]);
    let slides = |pairs: &[Ends]| mechanism.rubbing().any(|joint| pairs.contains(&pair(joint)));
    let floats = |group: &Group| floating_trees(mechanism, &group.pairs[0]).count() == 2;
    let touches = |group: &Group| mechanism.touches.iter().any(|joint| group.pairs == [pair(joint)]);
    found.retain(|group| slides(&group.pairs) || floats(group) && touches(group));
    if !found.iter().any(|group| slides(&group.pairs)) {
        return Vec::new();
    }
    let mut groups = join_around(mechanism, &found);
    groups.retain(|group| slides(&group.pairs));
    groups
}

/// Puts the equations of pairs on circles together, from tree to tree: trees on the world count as the world, which ends the way.
fn join_around(mechanism: &Mechanism, found: &[Group]) -> Vec<Group> {
    let floats = |tree: &usize| is_floating(mechanism, *tree);
    let nodes: Vec<Ends> = found.iter().map(|group| group.pairs[0].map(|tree| tree.filter(floats))).collect();
    let circles: Vec<usize> =
        (0..nodes.len()).filter(|&edge| is_on_circle(mechanism.bodies.len(), &nodes, edge)).collect();
    let mut joined = DisjointSets::new(nodes.len());
    // The first edge at each tree.
    let mut first = vec![None; mechanism.bodies.len()];
    for &edge in &circles {
        for &tree in nodes[edge].iter().flatten() {
            joined.unite(edge, *first[tree].get_or_insert(edge));
        }
    }
    let around = |part: Vec<usize>| Group {
        pairs: part.iter().flat_map(|&edge| found[edge].pairs.clone()).collect(),
        rows: part.iter().flat_map(|&edge| found[edge].rows.clone()).collect(),
    };
    joined.parts().into_iter().map(around).collect()
}

/// Whether a way along other edges leads from one node of an edge to its other node, between the world and trees of this number of bodies.
fn is_on_circle(bodies: usize, nodes: &[Ends], edge: usize) -> bool {
    let mut joined = DisjointSets::new(bodies + 1);
    let numbered = |ends: &Ends| ends.map(|tree| tree.unwrap_or(bodies));
    for (_, ends) in nodes.iter().enumerate().filter(|(other, _)| *other != edge) {
        let [one, other] = numbered(ends);
        joined.unite(one, other);
    }
    let [from, to] = numbered(&nodes[edge]);
    joined.first(from) == joined.first(to)
}

/// The trees at the ends of an equation, in order.
fn trees_of(mechanism: &Mechanism, ends: Ends) -> Ends {
    let mut trees = ends.map(|end| first_of_tree(mechanism, end));
    trees.sort_unstable();
    trees
}

/// The first body of the tree of a body.
pub(crate) fn first_of_tree(mechanism: &Mechanism, body: Option<usize>) -> Option<usize> {
    body.and_then(|body| ancestors(mechanism, body).last())
}

/// The trees of a pair that can move as a whole.
pub(crate) fn floating_trees(mechanism: &Mechanism, pair: &Ends) -> impl Iterator<Item = usize> {
    pair.iter().flatten().copied().filter(|&first| is_floating(mechanism, first))
}

pub(crate) fn is_floating(mechanism: &Mechanism, body: usize) -> bool {
    mechanism.bodies[body].joint.kind == JointKind::Floating
}

/// A body and its ancestors, up to the first of its tree.
pub(crate) fn ancestors(mechanism: &Mechanism, body: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(body), |&body| mechanism.bodies[body].parent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_on_circles_are_told_from_those_that_alone_join_two_sides() {
        // Two bodies that lean on each other on the world, and a third on one of them; a body between the world and a tree on it; one body alone.
        let nodes = [
            [None, Some(0)],
            [Some(0), Some(1)],
            [None, Some(1)],
            [Some(1), Some(2)],
            [None, Some(3)],
            [Some(3), None],
            [None, Some(4)],
        ];
        let on_circle: Vec<bool> = (0..nodes.len()).map(|edge| is_on_circle(5, &nodes, edge)).collect();
        assert_eq!(on_circle, [true, true, true, false, true, true, false]);
        // Links of one tree that touch each other are a circle by themselves.
        assert!(is_on_circle(1, &[[Some(0), Some(0)]], 0));
    }
}

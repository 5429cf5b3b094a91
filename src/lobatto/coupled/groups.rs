//! The groups of equations between trees whose contacts slide, of which some may imply others ([`crate::coupled::dependent`]).
//!
//! ```text
//!     nodes: the trees that float, and the world with all trees on it        edges: pairs of trees with equations between them, one of which slides
//!     a part of this graph with as many edges as nodes, or more, leads around: one group.  Otherwise each edge is a group of its own
//! ```
//!
//! A block between a wall and the jaw of a vice: the pairs (world, block) and (jaw, block) are two edges between two nodes.

use catena_mechanism::description::contact::TouchJoint;
use catena_mechanism::description::joint::JointKind;
use catena_mechanism::description::mechanism::Mechanism;
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

/// All groups of a mechanism in which contacts slide with friction, for the rows of its loops and then of its contacts.
pub(crate) fn sliding_groups(mechanism: &Mechanism, rows_of_closure: &[Range<usize>]) -> Vec<Group> {
    let mut found: Vec<Group> = Vec::new();
    let is_reeved = |number: usize| {
        number.checked_sub(mechanism.loops.len()).is_some_and(|touch| mechanism.touches[touch].is_reeved())
    };
    let closures = mechanism.closing_ends().zip(rows_of_closure).enumerate();
    for (number, ([a, b], rows)) in closures.filter(|(number, _)| !is_reeved(*number)) {
        let pair = trees_of(mechanism, [a.body, b.body]);
        // The first row of a contact is its gap; a rolling contact has more rows, of rates.
        let count = if number < mechanism.loops.len() { rows.len() } else { 1 };
        let of_these = rows.clone().take(count).map(|row| (row, [a.body, b.body]));
        match found.iter_mut().find(|known| known.pairs == [pair]) {
            Some(known) => known.rows.extend(of_these),
            None => found.push(Group { pairs: vec![pair], rows: of_these.collect() }),
        }
    }
    let slide = |joint: &TouchJoint| trees_of(mechanism, [joint.a.body, joint.b.body]);
    found.retain(|group| mechanism.rubbing().any(|joint| group.pairs == [slide(joint)]));
    join_around(mechanism, found)
}

/// Puts the equations of all pairs together that lead from tree to tree, if they lead around: trees on the world count as the world, which ends the
/// way. Pairs without sliding friction are not here: friction that holds shares no load with others
/// (`doc/decisions/033-friction-that-holds.md`).
fn join_around(mechanism: &Mechanism, mut found: Vec<Group>) -> Vec<Group> {
    let floating = |group: &Group| floating_trees(mechanism, &group.pairs[0]).collect::<Vec<usize>>();
    let mut joined: Vec<Group> = Vec::new();
    while !found.is_empty() {
        let first = found.remove(0);
        let mut nodes = floating(&first);
        let mut part = vec![first];
        while let Some(next) = found.iter().position(|group| floating(group).iter().any(|own| nodes.contains(own))) {
            let next = found.remove(next);
            nodes.extend(floating(&next));
            part.push(next);
        }
        nodes.sort_unstable();
        nodes.dedup();
        let on_world = part.iter().any(|group| floating(group).len() < 2);
        // A graph without circles has one edge less than nodes.
        if part.len() < nodes.len() + usize::from(on_world) {
            joined.extend(part);
            continue;
        }
        let mut around = Group { pairs: Vec::new(), rows: Vec::new() };
        for Group { pairs, rows } in part {
            around.pairs.extend(pairs);
            around.rows.extend(rows);
        }
        joined.push(around);
    }
    joined
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

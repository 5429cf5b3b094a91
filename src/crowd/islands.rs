//! Trees that candidates join, and what belongs to each group.

use crate::rows::Side;
use catena_mechanism::ground::disjoint_sets::DisjointSets;

/// Trees that influence each other in a step, and their candidates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Island {
    /// The trees by their numbers.
    pub trees: Vec<usize>,
    /// The candidates by their numbers.
    pub candidates: Vec<usize>,
}

/// The islands of this number of trees by candidates with their numbers, in the order of their lowest trees. Trees without candidates are left out.
pub fn islands(count: usize, blocks: impl Iterator<Item = (usize, [Option<Side>; 2])> + Clone) -> Vec<Island> {
    let mut joined = DisjointSets::new(count);
    let mut pressed = vec![false; count];
    for (_, sides) in blocks.clone() {
        join(&mut joined, sides);
        sides.iter().flatten().for_each(|side| pressed[side.tree] = true);
    }
    let mut numbers = vec![usize::MAX; count];
    let mut found: Vec<Island> = Vec::new();
    for tree in (0..count).filter(|&tree| pressed[tree]) {
        let own = joined.first(tree);
        if numbers[own] == usize::MAX {
            numbers[own] = found.len();
            found.push(Island::default());
        }
        found[numbers[own]].trees.push(tree);
    }
    for (number, sides) in blocks {
        if let Some(side) = sides.iter().flatten().next() {
            found[numbers[joined.first(side.tree)]].candidates.push(number);
        }
    }
    found
}

/// The groups of trees that these join.
pub fn groups(count: usize, blocks: impl Iterator<Item = [Option<Side>; 2]>) -> Vec<Vec<usize>> {
    let mut joined = DisjointSets::new(count);
    blocks.for_each(|sides| join(&mut joined, sides));
    joined.parts()
}

fn join(trees: &mut DisjointSets, sides: [Option<Side>; 2]) {
    if let [Some(a), Some(b)] = sides {
        trees.unite(a.tree, b.tree);
    }
}

//! Trees that candidates join, and what belongs to each group.

use crate::rows::Side;

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
    let mut parents: Vec<usize> = (0..count).collect();
    let mut pressed = vec![false; count];
    for (_, sides) in blocks.clone() {
        join(&mut parents, sides);
        sides.iter().flatten().for_each(|side| pressed[side.tree] = true);
    }
    let mut numbers = vec![usize::MAX; count];
    let mut found: Vec<Island> = Vec::new();
    for tree in (0..count).filter(|&tree| pressed[tree]) {
        let own = root(&mut parents, tree);
        if numbers[own] == usize::MAX {
            numbers[own] = found.len();
            found.push(Island::default());
        }
        found[numbers[own]].trees.push(tree);
    }
    for (number, sides) in blocks {
        if let Some(side) = sides.iter().flatten().next() {
            found[numbers[root(&mut parents, side.tree)]].candidates.push(number);
        }
    }
    found
}

fn root(parents: &mut [usize], mut tree: usize) -> usize {
    while parents[tree] != tree {
        parents[tree] = parents[parents[tree]];
        tree = parents[tree];
    }
    tree
}

/// The groups of trees that these join.
pub fn groups(count: usize, blocks: impl Iterator<Item = [Option<Side>; 2]>) -> Vec<Vec<usize>> {
    let mut parents: Vec<usize> = (0..count).collect();
    blocks.for_each(|sides| join(&mut parents, sides));
    let mut found: Vec<Vec<usize>> = vec![Vec::new(); count];
    (0..count).for_each(|tree| found[root(&mut parents, tree)].push(tree));
    found.retain(|group| !group.is_empty());
    found
}

fn join(parents: &mut [usize], sides: [Option<Side>; 2]) {
    if let [Some(a), Some(b)] = sides {
        let (a, b) = (root(parents, a.tree), root(parents, b.tree));
        parents[a.max(b)] = a.min(b);
    }
}

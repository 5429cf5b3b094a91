//! Trees that candidates join, and what belongs to each group.

use crate::events::crowd::contacts::Contacts;

/// Trees that influence each other in a step, and their candidates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Island {
    pub trees: Vec<usize>,
    pub candidates: Vec<usize>,
}

/// The islands of this number of trees by the candidates that a test keeps, in the order of their lowest trees.
pub(super) fn islands(count: usize, contacts: &Contacts, keeps: impl Fn(usize) -> bool) -> Vec<Island> {
    let mut parents: Vec<usize> = (0..count).collect();
    let kept = contacts.list.iter().enumerate().filter(|(number, _)| keeps(*number));
    let pairs = kept.clone().filter_map(|(_, candidate)| match candidate.sides {
        [Some(a), Some(b)] => Some((a.tree, b.tree)),
        _ => None,
    });
    for (a, b) in pairs {
        let (a, b) = (root(&mut parents, a), root(&mut parents, b));
        parents[a.max(b)] = a.min(b);
    }
    let mut numbers = vec![usize::MAX; count];
    let mut found: Vec<Island> = Vec::new();
    for tree in 0..count {
        let own = root(&mut parents, tree);
        if numbers[own] == usize::MAX {
            numbers[own] = found.len();
            found.push(Island::default());
        }
        found[numbers[own]].trees.push(tree);
    }
    for (number, candidate) in kept {
        if let Some(side) = candidate.sides.iter().flatten().next() {
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

/// The groups of trees that candidates of either list join.
pub(super) fn islands_of_both(count: usize, contacts: [&Contacts; 2]) -> Vec<Island> {
    let mut parents: Vec<usize> = (0..count).collect();
    for candidate in contacts.into_iter().flat_map(|contacts| &contacts.list) {
        if let [Some(a), Some(b)] = candidate.sides {
            let (a, b) = (root(&mut parents, a.tree), root(&mut parents, b.tree));
            parents[a.max(b)] = a.min(b);
        }
    }
    let mut found: Vec<Island> = vec![Island::default(); count];
    (0..count).for_each(|tree| found[root(&mut parents, tree)].trees.push(tree));
    found.retain(|island| !island.trees.is_empty());
    found
}

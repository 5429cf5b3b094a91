//! Chooses the joints that a run cuts: the spanning tree with the least work in the elimination.
//!
//! A closure is eliminated where its two branches meet ([`crate::plan::elimination`]), so that its equations sit in the fronts of all bodies on its
//! circuit. Let `m_b` be the equations of the closures that pass over body b, `W` the components of a twist (zero if the world is next), `f_b` its
//! freedoms, B a constant for the geometry of a body and C one for the rest of a solve:
//!
//! ```text
//!     work = C + Σ_b B + Σ_b f_b (W + m_b + 1)² + Σ_closures rows (W + max m)²
//! ```
//!
//! To find the least is hard (a minimum-congestion spanning tree: M. Ostrovskii, Discrete Math. 285 (2004) 219). Three trees are tried: the file's,
//! the one with the shortest branches, good where many joints are on the world, and one in which each body hangs on the latest before it, good for
//! ladders that hang by one end. The best of them is improved by exchanges: one closure comes in, one joint of its circuit goes out, while that is
//! less work.

use catena_mechanism::ground::disjoint_sets::DisjointSets;
use catena_mechanism::structure::spanning_tree::{Edge, Graph, Hang, Link, SpanningTree};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// B and C, in squares of fronts: rows of four-bars on random trees take the time that these say, within a third.
const BODY: f64 = 10.0;
const SOLVE: f64 = 400.0;
/// Another tree than the file's is taken if it has this part of its work, or less.
const WORTHWHILE: f64 = 0.8;
/// The search ends after this number of comparisons of entries: some milliseconds.
const PATIENCE: usize = 1_000_000;

/// The spanning tree to run a mechanism on, if another than the file's is worthwhile.
pub fn spanning_tree(graph: &Graph) -> Option<SpanningTree> {
    if !graph.has_choice() {
        return None;
    }
    let file: Vec<bool> = (0..graph.links.len()).map(|link| link < graph.bodies).collect();
    let order = visited(graph);
    let file = Rooted::new(graph, file);
    let mut best = [shortest(&order), latest(graph, &order)]
        .map(|preferred| Rooted::new(graph, spanning(graph, preferred)))
        .into_iter()
        .chain([file.clone()])
        .min_by(|a, b| a.work(graph).total_cmp(&b.work(graph)))?;
    best.improve(graph);
    (best.work(graph) <= WORTHWHILE * file.work(graph)).then(|| best.tree(graph))
}

/// The links at every body, and at the world, which comes last.
fn neighbours(graph: &Graph) -> Vec<Vec<usize>> {
    let mut at = vec![Vec::new(); graph.bodies + 1];
    for (index, link) in graph.links.iter().enumerate().filter(|(_, link)| link.edge.is_some()) {
        link.ends.iter().for_each(|end| at[end.unwrap_or(graph.bodies)].push(index));
    }
    at
}

/// The other end of a link; the world is the number after the last body.
fn other(graph: &Graph, link: usize, node: usize) -> usize {
    let [a, b] = graph.links[link].ends.map(|end| end.unwrap_or(graph.bodies));
    if a == node { b } else { a }
}

/// All nodes in the order of their distance from the world, each with the link that leads to it.
fn visited(graph: &Graph) -> Vec<(usize, Option<usize>)> {
    let at = neighbours(graph);
    let mut seen = vec![false; graph.bodies + 1];
    seen[graph.bodies] = true;
    let mut order = vec![(graph.bodies, None)];
    let mut next = 0;
    while let Some(&(node, _)) = order.get(next) {
        next += 1;
        for &link in &at[node] {
            let there = other(graph, link, node);
            if !std::mem::replace(&mut seen[there], true) {
                order.push((there, Some(link)));
            }
        }
    }
    order
}

/// The links of the shortest branches.
fn shortest(order: &[(usize, Option<usize>)]) -> Vec<usize> {
    order.iter().filter_map(|(_, link)| *link).collect()
}

/// The links to the latest neighbour that comes earlier.
fn latest(graph: &Graph, order: &[(usize, Option<usize>)]) -> Vec<usize> {
    let at = neighbours(graph);
    let mut rank = vec![0; graph.bodies + 1];
    order.iter().enumerate().for_each(|(number, &(node, _))| rank[node] = number);
    let of_node = |&(node, _): &(usize, Option<usize>)| {
        let earlier = at[node].iter().copied().filter(|&link| rank[other(graph, link, node)] < rank[node]);
        earlier.max_by_key(|&link| (rank[other(graph, link, node)], Reverse(link)))
    };
    order.iter().filter_map(of_node).collect()
}

/// A spanning tree of the links that must be in it, then of the preferred ones, then of the others.
fn spanning(graph: &Graph, preferred: Vec<usize>) -> Vec<bool> {
    let mut joined = DisjointSets::new(graph.bodies + 1);
    let mut used = vec![false; graph.links.len()];
    let fixed = (0..graph.links.len()).filter(|&link| graph.links[link].fixed);
    for link in fixed.chain(preferred).chain(0..graph.links.len()).filter(|&link| graph.links[link].edge.is_some()) {
        let [a, b] = graph.links[link].ends.map(|end| end.unwrap_or(graph.bodies));
        used[link] |= joined.unite(a, b);
    }
    used
}

/// A spanning tree with its root in the world.
#[derive(Clone)]
struct Rooted {
    /// Whether a link is in the tree.
    used: Vec<bool>,
    /// For every body the one above, and the link to it.
    above: Vec<(Option<usize>, usize)>,
    depth: Vec<usize>,
    /// The closures that pass over the link above a body, in order.
    crossing: Vec<Vec<usize>>,
    /// Their equations.
    rows: Vec<usize>,
}

impl Rooted {
    fn new(graph: &Graph, used: Vec<bool>) -> Self {
        let mut at = vec![Vec::new(); graph.bodies + 1];
        for (index, link) in graph.links.iter().enumerate().filter(|&(index, _)| used[index]) {
            link.ends.iter().for_each(|end| at[end.unwrap_or(graph.bodies)].push(index));
        }
        let mut above = vec![(None, usize::MAX); graph.bodies];
        let mut depth = vec![0; graph.bodies + 1];
        let mut waiting = vec![graph.bodies];
        while let Some(node) = waiting.pop() {
            for &link in &at[node] {
                let there = other(graph, link, node);
                if there < graph.bodies && above[there].1 == usize::MAX {
                    above[there] = (Some(node).filter(|&node| node < graph.bodies), link);
                    depth[there] = depth[node] + 1;
                    waiting.push(there);
                }
            }
        }
        let mut tree =
            Rooted { used, above, depth, crossing: vec![Vec::new(); graph.bodies], rows: vec![0; graph.bodies] };
        for link in (0..graph.links.len()).filter(|&link| !tree.used[link]) {
            for body in tree.circuit(graph, link) {
                tree.crossing[body].push(link);
                tree.rows[body] += graph.links[link].rows;
            }
        }
        tree
    }

    /// The bodies whose links to the one above are on the circuit of a closure; the last of each branch is next to where they meet.
    fn branches(&self, graph: &Graph, link: usize) -> [Vec<usize>; 2] {
        let mut ends = graph.links[link].ends;
        let mut branches = [Vec::new(), Vec::new()];
        let deep = |end: Option<usize>| end.map_or(0, |body| self.depth[body]);
        while ends[0] != ends[1] {
            let side = usize::from(deep(ends[1]) > deep(ends[0]));
            let Some(body) = ends[side] else { break };
            branches[side].push(body);
            ends[side] = self.above[body].0;
        }
        branches
    }

    fn circuit(&self, graph: &Graph, link: usize) -> Vec<usize> {
        self.branches(graph, link).concat()
    }

    /// Cost of the freedoms of a link, with `rows` equations over it.
    fn of_link(&self, graph: &Graph, link: usize, rows: usize) -> f64 {
        let Link { freedoms, ends, .. } = graph.links[link];
        let width = if ends.contains(&None) { 0 } else { graph.width };
        freedoms as f64 * ((width + rows + 1) as f64).powi(2)
    }

    fn work(&self, graph: &Graph) -> f64 {
        let of_bodies = (0..graph.bodies).map(|body| BODY + self.of_link(graph, self.above[body].1, self.rows[body]));
        let of_closures = (0..graph.links.len()).filter(|&link| !self.used[link]).map(|link| {
            let tops = self.branches(graph, link).map(|branch| branch.last().copied());
            let most = tops.iter().flatten().map(|&body| self.rows[body]).max().unwrap_or(0);
            let on_world = tops.iter().flatten().any(|&body| self.above[body].0.is_none());
            let width = if on_world { 0 } else { graph.width };
            graph.links[link].rows as f64 * ((width + most) as f64).powi(2)
        });
        SOLVE + of_bodies.sum::<f64>() + of_closures.sum::<f64>()
    }

    /// Exchanges closures for joints of their circuits while that is less work.
    fn improve(&mut self, graph: &Graph) {
        let mut compared = 0;
        loop {
            let mut improved = false;
            for link in (0..graph.links.len()).filter(|&link| graph.links[link].edge.is_some()) {
                if self.used[link] {
                    continue;
                }
                let circuit = self.circuit(graph, link);
                let mut best = (-1e-9 * self.work_on(graph, &circuit), None);
                for &out in circuit.iter().filter(|&&body| !graph.links[self.above[body].1].fixed) {
                    compared +=
                        circuit.iter().map(|&body| self.crossing[body].len() + self.crossing[out].len()).sum::<usize>();
                    let change = self.exchange(graph, link, out, &circuit);
                    if change < best.0 {
                        best = (change, Some(out));
                    }
                    if compared > PATIENCE {
                        break;
                    }
                }
                if let Some(out) = best.1 {
                    let mut used = std::mem::take(&mut self.used);
                    (used[link], used[self.above[out].1]) = (true, false);
                    *self = Rooted::new(graph, used);
                    compared += graph.links.len();
                    improved = true;
                }
                if compared > PATIENCE {
                    return;
                }
            }
            if !improved {
                return;
            }
        }
    }

    fn work_on(&self, graph: &Graph, circuit: &[usize]) -> f64 {
        circuit.iter().map(|&body| self.of_link(graph, self.above[body].1, self.rows[body])).sum()
    }

    /// Change of the work on a circuit if its closure `link` comes in and the link above `out` goes: each of the other links then carries the
    /// symmetric difference of its own closures and the closures over `out`.
    fn exchange(&self, graph: &Graph, link: usize, out: usize, circuit: &[usize]) -> f64 {
        let of = |link: usize| graph.links[link].rows;
        let gone = self.above[out].1;
        let mut change = self.of_link(graph, link, self.rows[out] - of(link) + of(gone));
        for &body in circuit {
            let own = self.above[body].1;
            change -= self.of_link(graph, own, self.rows[body]);
            if body != out {
                let both = common(&self.crossing[body], &self.crossing[out]).map(of).sum::<usize>();
                let rows = self.rows[body] + self.rows[out] - 2 * both + of(gone);
                change += self.of_link(graph, own, rows);
            }
        }
        change
    }

    /// The tree with its bodies in an order that keeps closures between neighbouring branches short.
    fn tree(&self, graph: &Graph) -> SpanningTree {
        let hang = |body: usize| {
            let (parent, link) = self.above[body];
            let by = graph.links[link].edge.unwrap_or(Edge::Tree(body));
            Hang { parent, by, backwards: graph.links[link].ends[0] == Some(body) }
        };
        let hangs: Vec<Hang> = (0..graph.bodies).map(hang).collect();
        let mut children = vec![Vec::new(); graph.bodies + 1];
        for body in 0..graph.bodies {
            children[self.above[body].0.unwrap_or(graph.bodies)].push(body);
        }
        // Closures that pass between two branches of the same body.
        let mut between: Vec<Vec<(usize, usize)>> = vec![Vec::new(); graph.bodies];
        for link in (0..graph.links.len()).filter(|&link| !self.used[link]) {
            if let [Some(&a), Some(&b)] = self.branches(graph, link).each_ref().map(|branch| branch.last()) {
                between[a].push((b, graph.links[link].rows));
                between[b].push((a, graph.links[link].rows));
            }
        }
        let mut order = Vec::with_capacity(graph.bodies);
        let mut waiting = arranged(&children[graph.bodies], &between);
        waiting.reverse();
        while let Some(body) = waiting.pop() {
            order.push(body);
            let own = arranged(&children[body], &between);
            waiting.extend(own.into_iter().rev());
        }
        SpanningTree { hangs, order }
    }
}

/// The common entries of two sorted lists.
fn common<'l>(one: &'l [usize], other: &'l [usize]) -> impl Iterator<Item = usize> + 'l {
    let mut next = 0;
    one.iter().copied().filter(move |entry| {
        while other.get(next).is_some_and(|there| there < entry) {
            next += 1;
        }
        other.get(next) == Some(entry)
    })
}

/// Branches in an order in which few equations are open between earlier and later branches: next is the one with the most equations to earlier ones,
/// less the equations to the others.
fn arranged(children: &[usize], between: &[Vec<(usize, usize)>]) -> Vec<usize> {
    if children.len() < 3 {
        return children.to_vec();
    }
    let total = |child: usize| between[child].iter().map(|&(_, rows)| rows as i64).sum::<i64>();
    let mut gain: std::collections::BTreeMap<usize, i64> =
        children.iter().map(|&child| (child, -total(child))).collect();
    let mut waiting: BinaryHeap<(i64, Reverse<usize>)> =
        gain.iter().map(|(&child, &own)| (own, Reverse(child))).collect();
    let mut order = Vec::with_capacity(children.len());
    while let Some((seen, Reverse(child))) = waiting.pop() {
        if gain.get(&child) != Some(&seen) {
            continue;
        }
        gain.remove(&child);
        order.push(child);
        for &(there, rows) in &between[child] {
            if let Some(own) = gain.get_mut(&there) {
                *own += 2 * rows as i64;
                waiting.push((*own, Reverse(there)));
            }
        }
    }
    order
}

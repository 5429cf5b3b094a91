//! The support vertex of a polytope with many vertices, found along its edges.
//!
//! A linear function `n · v` has no local maximum on the vertices and edges of a convex polytope but the global one: from any vertex, higher
//! neighbours lead on to the top. The walk starts from the best of the support vertices of 26 directions. Facets that a hull has merged are flat to
//! [`SLACK`] of the size only, so that all vertices within it of the top are compared at the end. The cost grows like the square root of the number
//! of vertices.
//!
//! Source: C. J. Ong and E. G. Gilbert, Fast versions of the Gilbert–Johnson–Keerthi distance algorithm, IEEE Transactions on Robotics and Automation
//! 17, 2001 (hill climbing along edges).

use nalgebra::Vector3;

/// Polytopes with fewer vertices are looked at vertex by vertex.
const FEWEST: usize = 64;
/// Vertices this near to the top, relative to the size, are compared.
const SLACK: f64 = 1e-9;

/// The neighbours of each vertex, and where walks begin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Neighbours {
    /// First indices of the neighbours of each vertex in `all`, and the end of the last ones; empty for small polytopes.
    starts: Vec<u32>,
    all: Vec<u32>,
    /// Support vertices of some directions.
    seeds: Vec<u32>,
    /// Vertices this near to the top are compared (m).
    slack: f64,
}

impl Neighbours {
    /// The neighbours of a polytope, whose edges have these ends; none if it is small, or if an edge is missing.
    pub fn new(vertices: &[Vector3<f64>], edges: impl Iterator<Item = [usize; 2]>) -> Self {
        let count = vertices.len();
        if count < FEWEST {
            return Neighbours::default();
        }
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); count];
        for [one, other] in edges {
            lists[one].push(other as u32);
            lists[other].push(one as u32);
        }
        if lists.iter().any(Vec::is_empty) {
            return Neighbours::default();
        }
        let mut starts = vec![0];
        let mut all = Vec::new();
        for list in lists {
            all.extend(list);
            starts.push(all.len() as u32);
        }
        let sign = |digit: u32| f64::from(digit % 3) - 1.0;
        let directions = (0..27).map(|number: u32| [sign(number / 9), sign(number / 3), sign(number)]);
        let farthest = |[x, y, z]: [f64; 3]| {
            let direction = Vector3::new(x, y, z);
            let along = |vertex: &u32| direction.dot(&vertices[*vertex as usize]);
            (0..count as u32).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or(0)
        };
        let seeds = directions.filter(|direction| *direction != [0.0; 3]).map(farthest).collect();
        let middle = vertices.iter().sum::<Vector3<f64>>() / count as f64;
        let size = vertices.iter().map(|vertex| (vertex - middle).norm()).fold(0.0, f64::max);
        Neighbours { starts, all, seeds, slack: SLACK * size }
    }

    /// Whether they are known.
    pub fn are_known(&self) -> bool {
        !self.starts.is_empty()
    }

    /// Those of a vertex.
    pub fn of(&self, vertex: usize) -> &[u32] {
        &self.all[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// Sees the neighbours of these vertices, or all of this number where they are not known.
    pub fn see_beside(&self, these: impl Iterator<Item = usize>, count: usize, mut see: impl FnMut(usize)) {
        if self.are_known() {
            these.for_each(|vertex| self.of(vertex).iter().for_each(|&next| see(next as usize)));
        } else {
            (0..count).for_each(see);
        }
    }

    /// The vertex that is farthest along a direction; the first of several. They have to be known.
    pub fn support(&self, vertices: &[Vector3<f64>], direction: &Vector3<f64>) -> usize {
        let along = |vertex: u32| direction.dot(&vertices[vertex as usize]);
        let best_seed = self.seeds.iter().copied().max_by(|a, b| along(*a).total_cmp(&along(*b)));
        let mut top = best_seed.unwrap_or(0);
        let mut height = along(top);
        loop {
            let next = self.of(top as usize).iter().copied().map(|vertex| (along(vertex), vertex));
            match next.max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((higher, vertex)) if higher > height => (height, top) = (higher, vertex),
                _ => break,
            }
        }
        self.compare(top, height, self.slack * direction.norm(), along)
    }

    /// The vertices that are connected with one along edges and pass a test, in the order of their numbers; `None` if there are more than `most`. They
    /// have to be known.
    pub fn connected(&self, from: usize, most: usize, passes: impl Fn(usize) -> bool) -> Option<Vec<usize>> {
        let mut reached = vec![false; self.starts.len() - 1];
        let (mut found, mut waiting) = (Vec::new(), vec![from]);
        if passes(from) {
            reached[from] = true;
            found.push(from);
        }
        while let Some(vertex) = waiting.pop() {
            for next in self.of(vertex).iter().map(|&next| next as usize) {
                if !reached[next] && passes(next) {
                    reached[next] = true;
                    found.push(next);
                    waiting.push(next);
                }
            }
            if found.len() > most {
                return None;
            }
        }
        found.sort_unstable();
        Some(found)
    }

    /// All vertices `n · v ≥ least`, in the order of their numbers. They have to be known.
    pub fn above(&self, vertices: &[Vector3<f64>], direction: &Vector3<f64>, least: f64) -> Vec<usize> {
        let along = |vertex: usize| direction.dot(&vertices[vertex]);
        // Facets are flat to the slack only: where they are not, a vertex above has perhaps no neighbour above.
        let deeper = least - self.slack * direction.norm();
        let top = self.support(vertices, direction);
        let found = self.connected(top, usize::MAX, |vertex| along(vertex) >= deeper).unwrap_or_default();
        found.into_iter().filter(|&vertex| along(vertex) >= least).collect()
    }

    /// The highest of the vertices that are connected with the top above its height less the slack, the first of several.
    fn compare(&self, top: u32, height: f64, slack: f64, along: impl Fn(u32) -> f64) -> usize {
        let near = |vertex: &u32| along(*vertex) >= height - slack;
        if !self.of(top as usize).iter().any(near) {
            return top as usize;
        }
        let mut seen = vec![top];
        let mut next = 0;
        while next < seen.len() {
            for &vertex in self.of(seen[next] as usize) {
                if near(&vertex) && !seen.contains(&vertex) {
                    seen.push(vertex);
                }
            }
            next += 1;
        }
        let best = seen.into_iter().map(|vertex| (along(vertex), vertex));
        best.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map_or(top, |(_, vertex)| vertex) as usize
    }
}

//! Fewer triangles for nearly the same surface: edges collapse in the order of the error that this makes.
//!
//! A vertex v has the sum of squared distances to the planes (n, d) of the triangles around it, weighted by their areas A:
//!
//! ```text
//!     Q(v) = Σ A (n·v + d)² = vᵀ M v + 2 bᵀ v + c        M = Σ A n nᵀ,  b = Σ A d n,  c = Σ A d²
//! ```
//!
//! The collapse of an edge puts one vertex at the minimum of the sum of both Q. Edges of one triangle only are borders: a plane
//! through each, square to its triangle, keeps them where they are. A collapse that would turn a triangle over is not made.
//!
//! Source: Garland and Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997.

use nalgebra::{Matrix3, Vector3};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// How much more the planes of borders count.
const BORDER: f64 = 10.0;

/// The largest turn of a triangle in a collapse: the least cosine between its normals before and after.
const LEAST_COSINE: f64 = 0.2;

/// Q of the header.
#[derive(Clone, Copy)]
struct Quadric {
    m: Matrix3<f64>,
    b: Vector3<f64>,
    c: f64,
}

impl Quadric {
    const ZERO: Quadric = Quadric {
        m: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        b: Vector3::new(0.0, 0.0, 0.0),
        c: 0.0,
    };

    /// The quadric of the plane with unit normal `n` through `point`.
    fn plane(n: Vector3<f64>, point: &Vector3<f64>, weight: f64) -> Self {
        let d = -n.dot(point);
        Quadric { m: n * n.transpose() * weight, b: n * (d * weight), c: d * d * weight }
    }

    fn plus(&self, other: &Quadric) -> Self {
        Quadric { m: self.m + other.m, b: self.b + other.b, c: self.c + other.c }
    }

    fn at(&self, v: &Vector3<f64>) -> f64 {
        (v.dot(&(self.m * v)) + 2.0 * self.b.dot(v) + self.c).max(0.0)
    }

    /// The best place for a vertex instead of `a` and `b`, and Q there.
    fn best(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let scale = self.m.norm();
        let solved = (self.m.determinant().abs() > 1e-6 * scale.powi(3)).then(|| self.m.try_inverse()).flatten();
        let middle = (a + b) * 0.5;
        let reach = (a - b).norm();
        let minimum = solved.map(|inverse| inverse * -self.b).filter(|v| (v - middle).norm() <= 2.0 * reach);
        let places = [minimum, Some(middle), Some(*a), Some(*b)];
        let rated = places.into_iter().flatten().map(|v| (v, self.at(&v)));
        rated.min_by(|one, other| one.1.total_cmp(&other.1)).unwrap_or((middle, f64::INFINITY))
    }
}

/// An edge that may collapse, with the number of moves of both its ends at its creation.
struct Edge {
    cost: f64,
    ends: [u32; 2],
    moved: [u32; 2],
}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.ends.cmp(&other.ends)).then(self.moved.cmp(&other.moved))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Edge {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Edge {}

struct Simplifier {
    vertices: Vec<Vector3<f64>>,
    quadrics: Vec<Quadric>,
    /// Triangles around each vertex; some of them may be gone.
    around: Vec<Vec<u32>>,
    moved: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    is_gone: Vec<bool>,
    edges: BinaryHeap<Reverse<Edge>>,
}

/// Collapses edges until at most `target` triangles are left, or no edge may collapse; vertices that no triangle uses any more stay.
pub(super) fn simplify(vertices: &mut Vec<[f64; 3]>, triangles: &mut Vec<[u32; 3]>, target: usize) {
    let mut work = Simplifier::new(vertices, triangles);
    let mut left = triangles.len();
    while left > target {
        let Some(Reverse(edge)) = work.edges.pop() else { break };
        left -= work.collapse(&edge);
    }
    *vertices = work.vertices.iter().map(|&v| v.into()).collect();
    let kept = work.triangles.iter().zip(&work.is_gone).filter(|(_, gone)| !**gone);
    *triangles = kept.map(|(triangle, _)| *triangle).collect();
}

impl Simplifier {
    fn new(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut work = Simplifier {
            vertices: vertices.iter().map(|&v| v.into()).collect(),
            quadrics: vec![Quadric::ZERO; vertices.len()],
            around: vec![Vec::new(); vertices.len()],
            moved: vec![0; vertices.len()],
            triangles: triangles.to_vec(),
            is_gone: vec![false; triangles.len()],
            edges: BinaryHeap::new(),
        };
        let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
        for (index, &[a, b, c]) in triangles.iter().enumerate() {
            let normal = work.normal(&[a, b, c]);
            let area = normal.norm();
            for corner in [a, b, c] {
                work.around[corner as usize].push(index as u32);
                if area > 0.0 {
                    let plane = Quadric::plane(normal / area, &work.vertices[a as usize], area);
                    work.quadrics[corner as usize] = work.quadrics[corner as usize].plus(&plane);
                }
            }
            sides.extend([[a, b], [b, c], [c, a]].map(|[p, q]| ([p.min(q), p.max(q)], index as u32)));
        }
        sides.sort_unstable();
        for same in sides.chunk_by(|one, other| one.0 == other.0) {
            let (ends, triangle) = same[0];
            if same.len() == 1 {
                work.hold_border(ends, triangle as usize);
            }
        }
        for same in sides.chunk_by(|one, other| one.0 == other.0) {
            work.offer(same[0].0);
        }
        work
    }

    /// Twice the area of a triangle along its normal.
    fn normal(&self, &[a, b, c]: &[u32; 3]) -> Vector3<f64> {
        let [a, b, c] = [a, b, c].map(|corner| self.vertices[corner as usize]);
        (b - a).cross(&(c - a))
    }

    fn hold_border(&mut self, ends: [u32; 2], triangle: usize) {
        let [p, q] = ends.map(|end| self.vertices[end as usize]);
        let along = q - p;
        let across = self.normal(&self.triangles[triangle]).cross(&along);
        let length = across.norm();
        if length > 0.0 {
            let plane = Quadric::plane(across / length, &p, BORDER * along.norm_squared());
            for end in ends {
                self.quadrics[end as usize] = self.quadrics[end as usize].plus(&plane);
            }
        }
    }

    fn offer(&mut self, ends: [u32; 2]) {
        let [a, b] = ends.map(|end| end as usize);
        let sum = self.quadrics[a].plus(&self.quadrics[b]);
        let (_, cost) = sum.best(&self.vertices[a], &self.vertices[b]);
        self.edges.push(Reverse(Edge { cost, ends, moved: [self.moved[a], self.moved[b]] }));
    }

    /// Collapses an edge if it is still valid and no triangle turns over; returns the number of triangles that this removes.
    fn collapse(&mut self, edge: &Edge) -> usize {
        let [a, b] = edge.ends.map(|end| end as usize);
        if [self.moved[a], self.moved[b]] != edge.moved {
            return 0;
        }
        let sum = self.quadrics[a].plus(&self.quadrics[b]);
        let (place, _) = sum.best(&self.vertices[a], &self.vertices[b]);
        if self.turns_over(a, b, &place) || self.turns_over(b, a, &place) {
            return 0;
        }
        self.vertices[a] = place;
        self.quadrics[a] = sum;
        // Earlier offers of either end are void.
        self.moved[a] += 1;
        self.moved[b] = u32::MAX;
        let of_b = std::mem::take(&mut self.around[b]);
        let mut gone = 0;
        for index in of_b {
            let triangle = &mut self.triangles[index as usize];
            if self.is_gone[index as usize] {
                continue;
            }
            if triangle.contains(&(a as u32)) {
                self.is_gone[index as usize] = true;
                gone += 1;
            } else {
                triangle.iter_mut().filter(|corner| **corner == b as u32).for_each(|corner| *corner = a as u32);
                self.around[a].push(index);
            }
        }
        let is_gone = &self.is_gone;
        self.around[a].retain(|&index| !is_gone[index as usize]);
        let corners = self.around[a].iter().flat_map(|&index| self.triangles[index as usize]);
        let mut neighbours: Vec<u32> = corners.filter(|&corner| corner != a as u32).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        for neighbour in neighbours {
            self.offer([neighbour.min(a as u32), neighbour.max(a as u32)]);
        }
        gone
    }

    /// Whether a triangle at `end`, that is not at `other`, would turn over if `end` were at `place`.
    fn turns_over(&self, end: usize, other: usize, place: &Vector3<f64>) -> bool {
        self.around[end].iter().any(|&index| {
            let triangle = &self.triangles[index as usize];
            if self.is_gone[index as usize] || triangle.contains(&(other as u32)) {
                return false;
            }
            let [p, q, r] =
                triangle.map(|corner| if corner as usize == end { *place } else { self.vertices[corner as usize] });
            let (before, after) = (self.normal(triangle), (q - p).cross(&(r - p)));
            before.dot(&after) <= LEAST_COSINE * before.norm() * after.norm()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::simplify;

    /// A flat square of `n` by `n` cells with a bump in the middle if `height` is not zero.
    fn grid(n: u32, height: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let at = |i: u32, j: u32| {
            let (x, y) = (f64::from(i), f64::from(j));
            let z = if 2 * i == n && 2 * j == n { height } else { 0.0 };
            [x, y, z]
        };
        let vertices = (0..=n).flat_map(|i| (0..=n).map(move |j| at(i, j))).collect();
        let corner = |i: u32, j: u32| i * (n + 1) + j;
        let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let halves = |(i, j)| {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        (vertices, cells.flat_map(halves).collect())
    }

    fn area(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
        let corner = |k: u32| nalgebra::Vector3::from(vertices[k as usize]);
        triangles.iter().map(|&[a, b, c]| 0.5 * (corner(b) - corner(a)).cross(&(corner(c) - corner(a))).norm()).sum()
    }

    #[test]
    fn a_flat_square_becomes_few_triangles_with_the_same_area() {
        let (mut vertices, mut triangles) = grid(20, 0.0);
        simplify(&mut vertices, &mut triangles, 8);
        assert!(triangles.len() <= 8, "{}", triangles.len());
        // Its border may move along itself only, which planes through it keep to the rounding of sums of 400 squares.
        assert!((area(&vertices, &triangles) - 400.0).abs() < 1e-6, "{}", area(&vertices, &triangles));
    }

    #[test]
    fn what_stands_out_stays_and_the_same_input_gives_the_same_output() {
        let run = || {
            let (mut vertices, mut triangles) = grid(20, 5.0);
            simplify(&mut vertices, &mut triangles, 60);
            (vertices, triangles)
        };
        let (vertices, triangles) = run();
        assert!(triangles.len() <= 60);
        let top = triangles.iter().flatten().map(|&k| vertices[k as usize][2]).fold(0.0, f64::max);
        // The tip is the only vertex above the plane: without it the height is zero.
        assert!(top > 4.0, "{top}");
        assert_eq!(run(), (vertices, triangles));
    }

    #[test]
    fn triangles_without_area_and_edges_of_three_triangles_do_no_harm() {
        let mut vertices = vec![[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
        let mut triangles = vec![[0, 1, 2], [0, 2, 3], [0, 2, 4], [0, 2, 5], [3, 3, 4]];
        simplify(&mut vertices, &mut triangles, 0);
        assert!(triangles.len() < 5);
    }
}

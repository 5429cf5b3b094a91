//! The places of two small polytopes by their separating axes, for questions that are asked very often.
//!
//! ```text
//!     sep(n) = min_b n · q − max_a n · p          n: normals of faces of a, of −b, and ±(e × f)/|e × f| of directions of edges
//!     distance of the cores ≥ max sep(n);         two polytopes overlap if and only if all of them are negative
//! ```
//!
//! The largest separation proves that the two are apart, or is minus their depth. Where it is below a bound, vertices over faces and crossing edges
//! are the places that `manifold.rs` finds among all pairs of features, by the same tests; a corner that is nearest to a corner or an edge is left
//! to it.
//!
//! Source: S. Gottschalk, Separating axis theorem, TR96-024, University of North Carolina (1996).

use crate::distances::manifold::leave_corners;
use crate::features::both::{Both, Candidate};
use crate::features::feature::FeatureId;
use crate::shapes::convex::Core;
use crate::shapes::polytope::Polytope;
use nalgebra::Vector3;

/// The most products of edges that are tried as axes.
const MOST_AXES: usize = 64;
/// Two edges with a smaller sine between them have no axis of their own: a face has the same one.
const PARALLEL: f64 = 1e-4;
/// An axis of two edges is better than the axis of a face by more than this part of the size.
const BETTER: f64 = 1e-9;
/// Normals of places are within 60° of the best axis.
const TURNED: f64 = 0.5;

/// The answer.
pub enum Found {
    /// The two are farther apart than the bound: at least this (m).
    Apart(f64),
    /// All places below the bound.
    Places(Vec<Candidate>),
    /// Another way has to be taken.
    Unknown,
}

/// The places of two polytopes whose gap is below a bound (m).
pub fn places(both: &Both, near: f64) -> Found {
    let (Core::Polytope(a), Core::Polytope(b)) = (&both.a.core, &both.b.core) else { return Found::Unknown };
    let axes = a.directions.len() * b.directions.len();
    if both.a.radius + both.b.radius > 0.0 || axes == 0 || axes > MOST_AXES {
        return Found::Unknown;
    }
    let moved: Vec<Vector3<f64>> = b.vertices.iter().map(|vertex| both.of_b(vertex)).collect();
    let size = both.size();
    let of_a: Vec<f64> =
        a.faces.iter().map(|face| least(&moved, &face.normal) - height(a, face.corners[0], &face.normal)).collect();
    let outward: Vec<Vector3<f64>> = b.faces.iter().map(|face| both.turned(&face.normal)).collect();
    let faces_of_b = b.faces.iter().zip(&outward);
    let of_b: Vec<f64> =
        faces_of_b.map(|(face, normal)| least(&a.vertices, normal) - normal.dot(&moved[face.corners[0]])).collect();
    let mut best = (f64::NEG_INFINITY, Vector3::zeros());
    let on_a = of_a.iter().zip(a.faces.iter().map(|face| face.normal));
    for (&separation, normal) in on_a.chain(of_b.iter().zip(outward.iter().map(|normal| -normal))) {
        if separation > best.0 {
            best = (separation, normal);
        }
    }
    if best.0 >= near {
        return Found::Apart(best.0);
    }
    let turned: Vec<Vector3<f64>> = b.directions.iter().map(|direction| both.turned(direction)).collect();
    let mut enough = best.0 + BETTER * size;
    for one in &a.directions {
        for other in &turned {
            let product = one.cross(other);
            let square = product.norm_squared();
            if square < PARALLEL * PARALLEL {
                continue;
            }
            let normal = product / square.sqrt();
            let (low, high) = (least(&a.vertices, &normal), -least(&a.vertices, &-normal));
            let (near_b, far_b) = (least(&moved, &normal), -least(&moved, &-normal));
            for (separation, normal) in [(near_b - high, normal), (low - far_b, -normal)] {
                if separation > enough {
                    (best, enough) = ((separation, normal), separation);
                }
            }
        }
    }
    let (distance, normal) = best;
    if distance >= near {
        return Found::Apart(distance);
    }
    let depth = near - distance + 1e-12 * size;
    let sharp = distance <= 1e-9 * size;
    let outside = if sharp { -(near.abs().min(1e-3 * size) + 1e-12 * size) } else { -1e-9 * size };
    let bounds = Bounds { normal, near, tolerance: 10.0 * depth, outside };
    let mut found = Vec::new();
    over_faces(a, &moved, &of_a, &bounds, |face| a.faces[face].normal, |candidate| found.push(candidate));
    let of_first = found.len();
    let vertices: Vec<Vector3<f64>> =
        a.vertices.iter().map(|vertex| both.rotation.tr_mul(&(vertex - both.translation))).collect();
    let back = Bounds { normal: -both.rotation.tr_mul(&normal), ..bounds };
    over_faces(b, &vertices, &of_b, &back, |face| b.faces[face].normal, |candidate| found.push(candidate));
    for candidate in &mut found[of_first..] {
        let [q, p] = candidate.points.map(|point| both.of_b(&point));
        candidate.points = [p, q];
        candidate.normal = -both.turned(&candidate.normal);
        candidate.features.reverse();
    }
    crossings([a, b], &moved, depth, &bounds, &mut found);
    // Otherwise a corner is nearest to a corner or an edge.
    if found.iter().all(|candidate| candidate.distance() > distance + BETTER * size) {
        return Found::Unknown;
    }
    leave_corners(both, &mut found);
    Found::Places(found)
}

/// What makes a place.
#[derive(Clone, Copy)]
struct Bounds {
    /// The best axis.
    normal: Vector3<f64>,
    /// The largest gap, the largest gap over the separation along the own normal, and how far inside its features a point is at least (m).
    near: f64,
    tolerance: f64,
    outside: f64,
}

/// The places of points (m) over the faces of a polytope, whose separations are known, in its frame.
fn over_faces(
    polytope: &Polytope,
    points: &[Vector3<f64>],
    separations: &[f64],
    bounds: &Bounds,
    normal: impl Fn(usize) -> Vector3<f64>,
    mut keep: impl FnMut(Candidate),
) {
    for (face, &separation) in separations.iter().enumerate() {
        let normal = normal(face);
        if separation >= bounds.near || normal.dot(&bounds.normal) < TURNED {
            continue;
        }
        let from = height(polytope, polytope.faces[face].corners[0], &normal);
        for (vertex, point) in points.iter().enumerate() {
            let gap = normal.dot(point) - from;
            if gap < bounds.near
                && gap - separation <= bounds.tolerance
                && polytope.inside_face(face, point) >= bounds.outside
            {
                let features = [FeatureId::Face(face as u32), FeatureId::Vertex(vertex as u32)];
                keep(Candidate { normal, points: [point - normal * gap, *point], features, separation });
            }
        }
    }
}

/// The places where edges cross, with an end in the slab below the support plane.
fn crossings([a, b]: [&Polytope; 2], moved: &[Vector3<f64>], depth: f64, bounds: &Bounds, found: &mut Vec<Candidate>) {
    let normal = bounds.normal;
    let above = -least(&a.vertices, &-normal) - depth;
    let below = least(moved, &normal) + depth;
    for (one, edge) in a.edges.iter().enumerate() {
        let [p, end] = edge.ends.map(|end| a.vertices[end]);
        if normal.dot(&p).max(normal.dot(&end)) < above {
            continue;
        }
        let e = end - p;
        for (other, partner) in b.edges.iter().enumerate() {
            let [q, end] = partner.ends.map(|end| moved[end]);
            if normal.dot(&q).min(normal.dot(&end)) > below {
                continue;
            }
            let f = end - q;
            let product = e.cross(&f);
            let (square, squares) = (product.norm_squared(), [e.norm_squared(), f.norm_squared()]);
            let along = product.dot(&normal);
            if square <= PARALLEL * PARALLEL * squares[0] * squares[1] || along * along < TURNED * TURNED * square {
                continue;
            }
            let between = q - p;
            let (s, t) = (between.cross(&f).dot(&product) / square, between.cross(&e).dot(&product) / square);
            let lengths = squares.map(f64::sqrt);
            let inside = (s.min(1.0 - s) * lengths[0]).min(t.min(1.0 - t) * lengths[1]);
            if inside < bounds.outside {
                continue;
            }
            let direction = product * (along.signum() / square.sqrt());
            let gap = direction.dot(&between);
            if gap >= bounds.near {
                continue;
            }
            let separation = least(moved, &direction) + least(&a.vertices, &-direction);
            if gap - separation <= bounds.tolerance {
                let points = [p + e * s, q + f * t];
                let features = [FeatureId::Edge(one as u32), FeatureId::Edge(other as u32)];
                found.push(Candidate { normal: direction, points, features, separation });
            }
        }
    }
}

/// `min n · p` over points (m).
fn least(points: &[Vector3<f64>], normal: &Vector3<f64>) -> f64 {
    points.iter().map(|point| normal.dot(point)).fold(f64::INFINITY, f64::min)
}

/// `n · v` of a vertex (m).
fn height(polytope: &Polytope, vertex: usize, normal: &Vector3<f64>) -> f64 {
    normal.dot(&polytope.vertices[vertex])
}

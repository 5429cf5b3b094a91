//! How deep two shapes overlap, by separating directions: no part of the library's geometry.
//!
//! For convex sets A and B and a unit vector d, `sep(d) = min_A d·x − max_B d·x` (m). The depth is `−max_d sep(d)`. A direction with `sep(d) ≥ −ε`
//! proves that they overlap by at most ε, so that an overlap can be claimed wrongly, if no candidate is near the best direction, but never missed.
//! Candidates are face normals, cross products of edges, and the directions between the nearest points of shrunk sets.

use crate::shapes::Shape;
use nalgebra::{DMatrix, DVector, IsometryMatrix3, Point3, Vector3};

/// A convex set in the world: the hull of points, blown up by a radius, or a disc swept along an axis, or a half space.
pub struct Convex {
    centre: Vector3<f64>,
    /// The largest distance from the centre.
    extent: f64,
    points: Vec<Vector3<f64>>,
    radius: f64,
    /// Axis and radius of a cylinder, whose points are the centres of its ends.
    rim: Option<(Vector3<f64>, f64)>,
    /// The outward normal of a half space, which ends at the centre.
    normal: Option<Vector3<f64>>,
    /// Normals of faces, and directions of edges.
    normals: Vec<Vector3<f64>>,
    edges: Vec<Vector3<f64>>,
}

impl Convex {
    /// The convex parts of a shape at a pose.
    pub fn of(shape: &Shape, pose: &IsometryMatrix3<f64>) -> Vec<Convex> {
        let at = |x: &Vector3<f64>| (pose * Point3::from(*x)).coords;
        let axes: Vec<Vector3<f64>> = (0..3).map(|axis| pose.rotation * Vector3::ith(axis, 1.0)).collect();
        let ends = |half: f64| [half, -half].map(|z| at(&Vector3::new(0.0, 0.0, z))).to_vec();
        let plain = Convex {
            centre: pose.translation.vector,
            extent: shape.extent(),
            points: vec![pose.translation.vector],
            radius: 0.0,
            rim: None,
            normal: None,
            normals: Vec::new(),
            edges: Vec::new(),
        };
        match shape {
            Shape::HalfSpace => vec![Convex { normal: Some(axes[2]), normals: vec![axes[2]], ..plain }],
            Shape::Sphere { radius } => vec![Convex { radius: *radius, ..plain }],
            Shape::Box { size } => {
                let corner =
                    |k: usize| Vector3::from_fn(|axis, _| size[axis] * if k >> axis & 1 == 1 { 0.5 } else { -0.5 });
                let points = (0..8).map(|k| at(&corner(k))).collect();
                vec![Convex { points, normals: axes.clone(), edges: axes, ..plain }]
            }
            Shape::Cylinder { radius, length } => {
                let rim = Some((axes[2], *radius));
                vec![Convex { points: ends(0.5 * length), rim, normals: vec![axes[2]], edges: vec![axes[2]], ..plain }]
            }
            Shape::Capsule { radius, length } => {
                vec![Convex { points: ends(0.5 * length), radius: *radius, edges: vec![axes[2]], ..plain }]
            }
            Shape::Polytope { corners, faces, .. } => {
                let points: Vec<_> = corners.iter().map(at).collect();
                let (normals, edges) = features(&points, faces);
                vec![Convex { points, normals, edges, ..plain }]
            }
            Shape::Hills { corners, faces, bottom, .. } => {
                let prism = |face: &[usize; 3]| {
                    let top = face.map(|corner| corners[corner]);
                    let below = top.map(|corner| Vector3::new(corner.x, corner.y, *bottom));
                    let points: Vec<_> = top.iter().chain(&below).map(at).collect();
                    let faces = [[0, 1, 2], [3, 4, 5], [0, 1, 3], [1, 2, 4], [2, 0, 5]];
                    let (normals, edges) = features(&points, &faces);
                    let centre = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
                    let extent = points.iter().map(|point| (point - centre).norm()).fold(0.0, f64::max);
                    Convex { centre, extent, points, normals, edges, ..plain.clone_empty() }
                };
                faces.iter().map(prism).collect()
            }
        }
    }

    fn clone_empty(&self) -> Convex {
        let (points, normals, edges) = (Vec::new(), Vec::new(), Vec::new());
        Convex { points, normals, edges, rim: None, normal: None, ..*self }
    }

    /// max over the set of d·x, for a unit vector d (m).
    fn support(&self, d: &Vector3<f64>) -> f64 {
        if let Some(normal) = &self.normal {
            return if (normal - d).norm() < 1e-12 { normal.dot(&self.centre) } else { f64::INFINITY };
        }
        let along = self.points.iter().map(|point| point.dot(d)).fold(f64::NEG_INFINITY, f64::max);
        // The cross product: 1 − cos² of a rounding is the square of 1e-8, and 2e-9 m of a rim of 10 cm.
        let rim = self.rim.map_or(0.0, |(axis, radius)| radius * axis.cross(d).norm());
        along + self.radius + rim
    }

    /// sep(d) of this set, above, and another, below.
    fn separation(&self, other: &Convex, d: &Vector3<f64>) -> f64 {
        -self.support(&-d) - other.support(d)
    }

    /// The point of the core (without the radius of spheres and capsules), shrunk about the centre, that is farthest along d.
    fn farthest(&self, d: &Vector3<f64>, shrink: f64) -> Vector3<f64> {
        let along = |point: &&Vector3<f64>| point.dot(d);
        let point = self.points.iter().max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or(&self.centre);
        let rim = self.rim.map_or(Vector3::zeros(), |(axis, radius)| {
            (d - axis * axis.dot(d)).try_normalize(1e-12).map_or(Vector3::zeros(), |outward| radius * outward)
        });
        self.centre + (point + rim - self.centre) * (1.0 - shrink)
    }

    /// The direction between the nearest points of two shrunk cores that do not meet (the algorithm of Gilbert, Johnson and Keerthi).
    fn direction(&self, other: &Convex, shrink: f64) -> Option<Vector3<f64>> {
        let mut simplex: Vec<Vector3<f64>> = Vec::new();
        let mut nearest = self.centre - other.centre;
        for _ in 0..100 {
            let corner = self.farthest(&-nearest, shrink) - other.farthest(&nearest, shrink);
            if nearest.dot(&(nearest - corner)) <= 1e-13 * nearest.norm_squared() && !simplex.is_empty() {
                break;
            }
            simplex.push(corner);
            let (to, kept) = nearest_of(&simplex);
            if !simplex.is_empty() && kept.len() == 4 {
                return None;
            }
            (nearest, simplex) = (to, kept);
        }
        nearest.try_normalize(1e-12)
    }

    /// The overlap with another set as far as it exceeds `allowed` (m), else 0.
    pub fn depth(&self, other: &Convex, allowed: f64) -> f64 {
        let between = self.centre - other.centre;
        if self.normal.is_none() && other.normal.is_none() && between.norm() > self.extent + other.extent {
            return 0.0;
        }
        let mut deepest = f64::INFINITY;
        let mut separates = |d: &Vector3<f64>| {
            d.try_normalize(1e-9).is_some_and(|d| {
                deepest = deepest.min(-self.separation(other, &d));
                deepest <= allowed
            })
        };
        let normals = self.normals.iter().chain(&other.normals);
        if normals.flat_map(|normal| [*normal, -normal]).any(|normal| separates(&normal)) {
            return 0.0;
        }
        if self.normal.is_some() || other.normal.is_some() {
            return deepest;
        }
        let mut directions = SHRINKS.iter().filter_map(|shrink| self.direction(other, *shrink));
        let crosses = self.edges.iter().flat_map(|one| other.edges.iter().map(move |two| one.cross(two)));
        let mut crosses = crosses.flat_map(|cross| [cross, -cross]);
        if directions.any(|d| separates(&d)) || crosses.any(|d| separates(&d)) { 0.0 } else { deepest }
    }
}

/// Shares by which sets are shrunk to find directions. Sets that touch have no direction between their nearest points; slightly smaller ones have
/// nearly the right one.
const SHRINKS: [f64; 6] = [0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];

/// The point nearest to the origin in the hull of up to four points, and the points that it depends on.
fn nearest_of(points: &[Vector3<f64>]) -> (Vector3<f64>, Vec<Vector3<f64>>) {
    let mut best = (points[0], vec![points[0]]);
    for subset in 1_usize..1 << points.len() {
        let kept: Vec<Vector3<f64>> = (0..points.len()).filter(|k| subset >> k & 1 == 1).map(|k| points[k]).collect();
        // min |p₀ + E x|² with the edges E from p₀.
        let edges = DMatrix::from_fn(3, kept.len() - 1, |row, column| kept[column + 1][row] - kept[0][row]);
        let moved = if kept.len() == 1 {
            DVector::zeros(3)
        } else {
            let solved = (edges.transpose() * &edges).lu().solve(&(edges.transpose() * -kept[0]));
            let Some(x) = solved.filter(|x| x.iter().all(|share| *share >= 0.0) && x.sum() <= 1.0) else { continue };
            &edges * x
        };
        let to = kept[0] + Vector3::new(moved[0], moved[1], moved[2]);
        if to.norm_squared() < best.0.norm_squared() {
            best = (to, kept);
        }
    }
    best
}

/// Normals of faces, and directions of edges.
fn features(points: &[Vector3<f64>], faces: &[[usize; 3]]) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let edges = |face: &[usize; 3]| [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])];
    let edge = |(from, to): (usize, usize)| (points[to] - points[from]).normalize();
    let normal = |face: &[usize; 3]| {
        let [a, b, c] = face.map(|corner| points[corner]);
        (b - a).cross(&(c - a)).normalize()
    };
    (faces.iter().map(normal).collect(), faces.iter().flat_map(edges).map(edge).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Translation3};

    #[test]
    fn a_ball_that_touches_the_end_of_a_tilted_cylinder_does_not_overlap_it() {
        // Axes whose lengths are off by roundings, as products of rotations have them.
        for number in 1..20 {
            let even = Rotation3::from_euler_angles(0.1 * f64::from(number), 0.37 * f64::from(number), 0.0);
            let turn = Rotation3::from_matrix_unchecked(even.matrix() * (1.0 - 4e-16));
            let cylinder = IsometryMatrix3::from_parts(Translation3::identity(), turn);
            let place = turn * Vector3::new(0.01, 0.02, 0.2);
            let ball = IsometryMatrix3::from_parts(Translation3::from(place), Rotation3::identity());
            let [one] = &Convex::of(&Shape::Sphere { radius: 0.1 }, &ball)[..] else { panic!("one set") };
            let [other] = &Convex::of(&Shape::Cylinder { radius: 0.1, length: 0.2 }, &cylinder)[..] else {
                panic!("one set")
            };
            // Some roundings of 0.2 m.
            let depth = one.depth(other, 1e-15);
            assert!(depth <= 1e-15, "{number}: {depth:e}");
        }
    }

    #[test]
    fn known_distances_of_shapes_are_found_to_a_nanometre() {
        let at =
            |x: f64, y: f64, z: f64| IsometryMatrix3::from_parts(Translation3::new(x, y, z), Rotation3::identity());
        let cube = Shape::Box { size: Vector3::repeat(0.2) };
        let ball = Shape::Sphere { radius: 0.1 };
        let tilted = IsometryMatrix3::from_parts(
            Translation3::new(0.0, 0.0, 0.5),
            Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_4),
        );
        let can = Shape::Cylinder { radius: 0.1, length: 0.4 };
        let corner = 0.1 + 0.099 / 3.0_f64.sqrt();
        for (one, pose, other, place, depth) in [
            (&cube, at(0.0, 0.0, 0.19), &cube, at(0.05, 0.0, 0.0), 0.01),
            (&cube, at(0.0, 0.0, 0.2), &ball, at(0.0, 0.0, 0.01), 0.01),
            // The ball touches a corner along the diagonal.
            (&ball, at(corner, corner, corner), &cube, at(0.0, 0.0, 0.0), 0.001),
            (&can, tilted, &Shape::HalfSpace, at(0.0, 0.0, 0.3), 0.3 * 0.5_f64.sqrt() - 0.2),
            (&ball, at(0.0, 0.0, 0.31), &can, at(0.0, 0.0, 0.0), -0.01),
        ] {
            let sets = [Convex::of(one, &pose), Convex::of(other, &place)];
            let found = sets[0][0].depth(&sets[1][0], 1e-12);
            let right = f64::max(depth, 0.0);
            assert!((found - right).abs() < 1e-6 * right + 1e-9, "{one:?} and {other:?}: {found}, right {right}");
        }
    }
}

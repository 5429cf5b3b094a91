//! Points that stand for the rim of a disc that lies on a face which does not cover it.
//!
//! ```text
//!     |c + s (d − c)|² = r²,   0 ≤ s ≤ 1       the edge from c to d crosses the rim of radius r about the origin
//!     φ = (φ₁ + φ₂)/2                          the middle of an arc between two crossings
//! ```
//!
//! All in the plane of the face, in m and rad from the centre of the disc. A load between the chord and the arc would have no support, so an arc that
//! lies in the face has its middle as a point, if no fixed point of the rim is in the face. Beside a fixed point, other points are added as loads
//! need them.

use crate::features::both::Both;
use crate::features::feature::{FeatureId, Part, part, rim_point_towards};
use crate::features::lens::flat_end;
use crate::shapes::convex::{Core, Cylinder};
use crate::shapes::plane::across;
use crate::shapes::polytope::Polytope;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Arcs with less than this half angle (rad) have no point of their own: their ends are at the same place.
const LEAST: f64 = 1e-6;
/// Arcs beside one edge with less than this half angle (rad) have no point, because the middle of the edge touches there
/// ([`crate::features::crossing`]).
const LEAST_BESIDE: f64 = 1e-2;

/// A disc, seen along the normal: its rim is a circle about the origin.
struct Disc<'d> {
    both: &'d Both<'d>,
    /// Whether it is the second of the two shapes.
    second: bool,
    cylinder: &'d Cylinder,
    /// Its centre (m).
    centre: Vector3<f64>,
    /// Across the normal.
    axes: (Vector3<f64>, Vector3<f64>),
}

impl Disc<'_> {
    /// A point of the first shape or the second (m), from the centre of the disc.
    fn flat(&self, second: bool, point: Vector3<f64>) -> Vector2<f64> {
        let from_centre = if second { self.both.of_b(&point) } else { point } - self.centre;
        Vector2::new(self.axes.0.dot(&from_centre), self.axes.1.dot(&from_centre))
    }

    /// The face of a polytope that is against the end of the disc, which looks along `out`.
    fn face_against(&self, polytope: &Polytope, out: &Vector3<f64>) -> Option<Vec<Vector2<f64>>> {
        let turned = |normal: &Vector3<f64>| if self.second { *normal } else { self.both.turned(normal) };
        let faces = polytope.faces.iter().map(|face| (face, turned(&face.normal).dot(out)));
        let (face, _) = faces.max_by(|one, other| one.1.total_cmp(&other.1))?;
        Some(face.corners.iter().map(|&corner| self.flat(!self.second, polytope.vertices[corner])).collect())
    }

    /// The crossings of the edges of a face with the rim: angles (rad) in their order, with the number of the edge.
    fn crossings(&self, corners: &[Vector2<f64>]) -> Vec<(f64, usize)> {
        let mut crossings = Vec::new();
        for (edge, (from, to)) in corners.iter().zip(corners.iter().cycle().skip(1)).enumerate() {
            let along = to - from;
            let (square, half) = (along.norm_squared(), along.dot(from));
            let root = (half * half - square * (from.norm_squared() - self.cylinder.radius.powi(2))).sqrt();
            let parts = [-half - root, -half + root].map(|sum| sum / square);
            let on = parts.into_iter().filter(|part| (0.0..=1.0).contains(part));
            crossings.extend(on.map(|part| (angle(from + along * part), edge)));
        }
        crossings.sort_by(|one, other| one.0.total_cmp(&other.0));
        crossings
    }

    /// Whether a point of the rim is in a face: on one side of all edges, whichever way round they go.
    fn is_inside(&self, corners: &[Vector2<f64>], angle: f64) -> bool {
        let at = Vector2::new(angle.cos(), angle.sin()) * self.cylinder.radius;
        let sides =
            || corners.iter().zip(corners.iter().cycle().skip(1)).map(|(from, to)| (to - from).perp(&(at - from)));
        sides().all(|side| side > 0.0) || sides().all(|side| side < 0.0)
    }

    /// The point of the rim at an angle.
    fn point_at(&self, end: u32, angle: f64) -> FeatureId {
        let towards = self.axes.0 * angle.cos() + self.axes.1 * angle.sin();
        let own = if self.second { self.both.rotation.tr_mul(&towards) } else { towards };
        rim_point_towards(self.cylinder, end, &own)
    }
}

fn angle(place: Vector2<f64>) -> f64 {
    place.y.atan2(place.x).rem_euclid(TAU)
}

/// Adds points of the arcs of a rim that lie in a face of the other shape and are without points; `normal` points from the first to the second. Arcs
/// on a triangle of a mesh continue in its neighbours, and get no points.
pub fn points_on_faces(both: &Both, normal: &Vector3<f64>, of_a: &mut Vec<FeatureId>, of_b: &mut Vec<FeatureId>) {
    let (core, polytope, features, second) = match (&both.a.core, &both.b.core) {
        (core, Core::Polytope(polytope)) => (core, polytope, of_a, false),
        (Core::Polytope(polytope), core) => (core, polytope, of_b, true),
        _ => return,
    };
    let (Core::Cylinder(cylinder), Some(end)) = (core, flat_end(features)) else { return };
    if polytope.edges.iter().any(|edge| !edge.open) {
        return;
    }
    let own_centre = cylinder.rim_centre(end as usize);
    let (centre, out) = if second { (both.of_b(&own_centre), *normal) } else { (own_centre, -normal) };
    let disc = Disc { both, second, cylinder, centre, axes: across(normal) };
    let Some(corners) = disc.face_against(polytope, &out) else { return };
    let is_known = features.iter().any(|&name| match (name, part(core, name)) {
        (FeatureId::RimPoint { .. }, Part::Point(at)) => disc.is_inside(&corners, angle(disc.flat(second, at))),
        _ => false,
    });
    if is_known {
        return;
    }
    let crossings = disc.crossings(&corners);
    for (place, &(from, edge)) in crossings.iter().enumerate() {
        let (next, last) = crossings[(place + 1) % crossings.len()];
        let least = if edge == last { LEAST_BESIDE } else { LEAST };
        let arc = if place + 1 < crossings.len() { next - from } else { next + TAU - from };
        if disc.is_inside(&corners, from + 0.5 * arc) && arc > 2.0 * least {
            features.push(disc.point_at(end, from + 0.5 * arc));
        }
    }
}

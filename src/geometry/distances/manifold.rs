//! All places where two convex shapes nearly touch.
//!
//! Two shapes are at a distance d. Points whose distance is below a bound ε lie within ε − d of the support planes along the normal. The pairs of
//! features within these slabs whose points lie on them, whose gap is below ε and whose own normal separates the shapes up to 10 ε are the places:
//! for two faces the corners of the area that they share (vertices of either in the face of the other, and edges that cross). Places at the same
//! point are one. Among places in one plane with gaps that are linear over it, the ones inside their hull are left out, because the others decide
//! about them.

use crate::distances::nearest::{nearest, spans_plane};
use crate::features::arcs::points_on_faces;
use crate::features::both::{Both, Candidate};
use crate::features::crossing::beside_tangent;
use crate::features::feature::{FeatureId, Part, contact_features, features, inside, lies_near, part};
use crate::features::guesses::guesses;
use crate::features::lens::points_of_arcs;
use crate::features::meet::{Guess, meet};
use crate::shapes::convex::Core;
use crate::shapes::plane::{across, corners};
use nalgebra::{Matrix3, Vector3};

/// Places that are nearer than this to each other are one, relative to the size.
pub const SAME: f64 = 1e-7;
/// A point that is outside both edges of a corner may be this much farther from the corner than from the edges.
const CORNER: f64 = 20.0;

/// The places of two convex shapes whose gap is below a bound (m).
pub fn manifold(both: &Both, near: f64) -> Vec<Candidate> {
    nearest(both).map_or(Vec::new(), |closest| manifold_along(both, closest, near))
}

/// The same along the normal of these points, which separates them.
pub fn manifold_along(both: &Both, closest: Candidate, near: f64) -> Vec<Candidate> {
    let radii = both.a.radius + both.b.radius;
    let gap = closest.distance() - radii;
    // The closest pair always touches first, even if it is less than near by rounding only.
    if gap.is_nan() || gap >= near {
        return Vec::new();
    }
    let mut found = candidates(both, &closest, near, radii);
    if found.is_empty() {
        found.push(closest);
    }
    without_doubles(&mut found, SAME * both.a.size.min(both.b.size), [both.a.radius, both.b.radius]);
    without_inner(&mut found, 1e-12 * both.size());
    found
}

/// All pairs of features that pass the tests of the module.
fn candidates(both: &Both, closest: &Candidate, near: f64, radii: f64) -> Vec<Candidate> {
    let (a, b) = (&both.a.core, &both.b.core);
    let size = both.size();
    let normal = closest.normal;
    let own = both.rotation.tr_mul(&normal);
    let rounding = 1e-12 * size;
    let depth = (near - (closest.distance() - radii)) + rounding;
    let tolerance = 10.0 * depth;
    let (least_a, least_b) = (a.support(&normal) - depth, b.support(&-own) - depth);
    // Cores that touch have no direction between two points: there a vertex that passes an edge counts as being over one face or the other.
    let sharp = closest.distance() <= 1e-9 * size;
    // Away from there it is over a face as far as contacts keep their features: over an edge the gap of a rounded shape opens anew.
    let share = if sharp { 1e-3 } else { 1e-9 };
    let outside = -(near.abs().min(share * size) + rounding);
    let at_closest = Guess { normal, point: closest.points[1], at_point: false };
    let mut found = Vec::new();
    let mut of_a: Vec<FeatureId> = contact_features(a, &normal, depth).collect();
    let mut of_b: Vec<FeatureId> = contact_features(b, &-own, depth).collect();
    points_of_arcs(both, &normal, &mut of_a, &mut of_b);
    points_on_faces(both, &normal, &mut of_a, &mut of_b);
    let of_a = within(a, &of_a, &normal, least_a);
    let of_b = within(b, &of_b, &-own, least_b);
    // Places of shapes that do not overlap are no farther apart than their gap may be, but for how far they may be outside their features.
    let overlap = closest.distance() < -1e-9 * size;
    let most = if overlap { f64::INFINITY } else { near.abs() + radii - CORNER * outside + 1e-9 * size };
    let balls_b: Vec<Ball> =
        of_b.iter().map(|(other, _)| ball(b, *other).moved(&both.rotation, &both.translation)).collect();
    for &(one, own_of_a) in &of_a {
        let on_a = part(a, one);
        let ball_a = ball(a, one);
        for (&(other, own_of_b), ball_b) in of_b.iter().zip(&balls_b) {
            if ball_a.is_farther(ball_b, most) {
                continue;
            }
            let crosses = matches!(
                (one, other),
                (FeatureId::Rim(_), FeatureId::Edge(_)) | (FeatureId::Edge(_), FeatureId::Rim(_))
            );
            if !(crosses || own_of_a && own_of_b) {
                continue;
            }
            let on_b = part(b, other).moved(&both.rotation, &both.translation);
            if sharp && !spans_plane(&on_a, &on_b) {
                continue;
            }
            for guess in guesses(&on_a, &on_b, at_closest) {
                let Some((mut direction, points)) = meet(&on_a, &on_b, &guess) else { continue };
                if guess.normal != normal && direction.dot(&normal) < 0.0 {
                    direction = -direction;
                }
                let far = direction.dot(&(points[1] - points[0])) - radii >= near || direction.dot(&normal) < 0.5;
                let place = both.rotation.tr_mul(&(points[1] - both.translation));
                if far || inside(a, one, &points[0]) < outside || inside(b, other, &place) < outside {
                    continue;
                }
                let mut candidate = Candidate { normal: direction, points, features: [one, other], separation: 0.0 };
                if crosses && sharp {
                    leave_tangent(&mut candidate, [&on_a, &on_b]);
                }
                let separation = both.separation(&candidate.normal);
                candidate.separation = separation;
                if candidate.distance() - separation <= tolerance {
                    found.push(candidate);
                }
            }
        }
    }
    // Faces and vertices first, then sides: a place has the name of the simplest pair that it is.
    found.sort_by_key(|candidate| {
        let of = |name: &FeatureId| match name {
            FeatureId::Face(_) | FeatureId::Cap(_) => 0,
            FeatureId::Side => 1,
            _ => 2,
        };
        candidate.features.iter().map(of).min()
    });
    found
}

/// Makes a place of an edge and a rim, in these parts, one of a point of the edge and the cap, where the edge is along the tangent.
fn leave_tangent(candidate: &mut Candidate, parts: [&Part; 2]) {
    let Some(found) = beside_tangent(parts, &candidate.points, &candidate.normal) else { return };
    let renamed = |name: FeatureId| match name {
        FeatureId::Edge(edge) => FeatureId::EdgePoint { edge, part: found.part.to_bits() },
        FeatureId::Rim(end) => FeatureId::Cap(end),
        other => other,
    };
    let edge_first = matches!(candidate.features[0], FeatureId::Edge(_));
    candidate.features = candidate.features.map(renamed);
    candidate.points = if edge_first { found.points } else { [found.points[1], found.points[0]] };
    candidate.normal = found.normal;
}

/// The features and flat rims that reach into the slab below a support plane, each with whether it is one of the given features.
fn within(core: &Core, features: &[FeatureId], normal: &Vector3<f64>, least: f64) -> Vec<(FeatureId, bool)> {
    let own = features.iter().map(|&feature| (feature, true));
    let all = own.chain(flat_rims(core, features).map(|feature| (feature, false)));
    all.filter(|&(feature, _)| is_open(core, feature) && touches(core, feature, normal, least)).collect()
}

/// The rims that lie flat, for which points stand among these features: edges cross them still.
fn flat_rims(core: &Core, others: &[FeatureId]) -> impl Iterator<Item = FeatureId> {
    features(core).filter(move |feature| matches!(feature, FeatureId::Rim(_)) && !others.contains(feature))
}

/// A ball about all points of a feature: its centre and radius (m).
struct Ball(Vector3<f64>, f64);

impl Ball {
    fn moved(self, rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Self {
        Ball(rotation * self.0 + translation, self.1)
    }

    /// Whether all points of two features are farther apart than this (m).
    fn is_farther(&self, other: &Ball, most: f64) -> bool {
        let reach = self.1 + other.1 + most;
        (self.0 - other.0).norm_squared() > reach * reach
    }
}

/// The ball about a face, an edge or a vertex of a polytope; one without end about other features.
fn ball(core: &Core, feature: FeatureId) -> Ball {
    let Core::Polytope(polytope) = core else { return Ball(Vector3::zeros(), f64::INFINITY) };
    match feature {
        FeatureId::Vertex(number) => Ball(polytope.vertices[number as usize], 0.0),
        FeatureId::Edge(edge) | FeatureId::EdgePoint { edge, .. } => {
            let [from, to] = polytope.edges[edge as usize].ends.map(|end| polytope.vertices[end]);
            Ball((from + to) / 2.0, (to - from).norm() / 2.0)
        }
        FeatureId::Face(number) => {
            let corners = &polytope.faces[number as usize].corners;
            let at = |corner: &usize| polytope.vertices[*corner];
            let centre = corners.iter().map(at).sum::<Vector3<f64>>() / corners.len() as f64;
            Ball(centre, corners.iter().map(|corner| (at(corner) - centre).norm()).fold(0.0, f64::max))
        }
        _ => Ball(Vector3::zeros(), f64::INFINITY),
    }
}

/// Whether a feature can be touched.
fn is_open(core: &Core, feature: FeatureId) -> bool {
    match (core, feature) {
        (Core::Polytope(polytope), FeatureId::Edge(number)) => polytope.edges[number as usize].open,
        _ => true,
    }
}

/// Whether a feature reaches into the slab below a support plane.
fn touches(core: &Core, feature: FeatureId, normal: &Vector3<f64>, least: f64) -> bool {
    match (core, feature) {
        (Core::Polytope(polytope), FeatureId::Face(number)) => {
            let corners = &polytope.faces[number as usize].corners;
            corners.iter().any(|&corner| normal.dot(&polytope.vertices[corner]) >= least)
        }
        (Core::Polytope(polytope), FeatureId::Edge(number)) => {
            polytope.edges[number as usize].ends.iter().any(|&end| normal.dot(&polytope.vertices[end]) >= least)
        }
        (Core::Cylinder(_), _) => match part(core, feature) {
            Part::Plane(at, out) => normal.dot(&at) >= least && out.dot(normal) > 0.5,
            Part::Circle(centre, axis, radius) => normal.dot(&centre) + radius * axis.cross(normal).norm() >= least,
            _ => true,
        },
        _ => lies_near(core, feature, normal, least),
    }
}

/// Leaves the first of places whose points on either surface are nearer than a distance (m) to each other; the cores have these radii (m).
/// Because the core of a ball is a point, all its places have the same point there, and not on its surface.
pub fn without_doubles(found: &mut Vec<Candidate>, same: f64, radii: [f64; 2]) {
    let surface = |one: &Candidate| [one.points[0] + one.normal * radii[0], one.points[1] - one.normal * radii[1]];
    let mut kept: Vec<Candidate> = Vec::with_capacity(found.len());
    let mut places: Vec<[Vector3<f64>; 2]> = Vec::with_capacity(found.len());
    let near = |one: &Vector3<f64>, other: &Vector3<f64>| (one - other).norm() <= same;
    for candidate in found.drain(..) {
        let own = surface(&candidate);
        let double = |(other, points): (&Candidate, &[Vector3<f64>; 2])| {
            (near(&points[0], &own[0]) || near(&points[1], &own[1])) && other.normal.dot(&candidate.normal) > 0.9
        };
        if !kept.iter().zip(&places).any(double) {
            kept.push(candidate);
            places.push(own);
        }
    }
    *found = kept;
}

/// Leaves the corners of the hull of places whose normals agree and whose gaps are linear over the plane, to within a length (m).
pub fn without_inner(found: &mut Vec<Candidate>, rounding: f64) {
    if found.len() < 3 {
        return;
    }
    let normal = found[0].normal;
    let (x, y) = across(&normal);
    let flat = |candidate: &Candidate| Vector3::new(x.dot(&candidate.points[0]), y.dot(&candidate.points[0]), 1.0);
    let places: Vec<Vector3<f64>> = found.iter().map(flat).collect();
    let middle = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
    let spread = places.iter().map(|place| (place - middle).norm()).fold(0.0, f64::max);
    let offset = |place: &Vector3<f64>| (place - middle) / spread;
    let square: Matrix3<f64> =
        places.iter().map(|place| offset(place) + Vector3::z()).map(|row| row * row.transpose()).sum();
    let right: Vector3<f64> =
        places.iter().zip(found.iter()).map(|(place, one)| (offset(place) + Vector3::z()) * one.distance()).sum();
    // Places on one line have no plane of their own.
    let linear = square.try_inverse().filter(|inverse| inverse.amax() < 1e6).is_none_or(|inverse| {
        let plane = inverse * right;
        let misses = |(place, one): (&Vector3<f64>, &Candidate)| {
            (plane.dot(&(offset(place) + Vector3::z())) - one.distance()).abs()
                > rounding.max(1e-9 * one.distance().abs())
        };
        !places.iter().zip(found.iter()).any(misses)
    });
    if !linear || found.iter().any(|one| one.normal.dot(&normal) < 1.0 - 1e-9) {
        return;
    }
    let corners = corners(&places, 1e-9 * spread);
    let mut number = 0;
    found.retain(|_| {
        number += 1;
        corners.contains(&(number - 1))
    });
}

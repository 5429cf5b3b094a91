//! All places where two convex shapes nearly touch.
//!
//! Two shapes are at a distance d. Points whose distance is below a bound ε lie within ε − d of the support planes along the normal. The pairs of
//! features within these slabs whose points lie on them, whose gap is below ε and whose own normal separates the shapes up to 10 ε are the places:
//! for two faces the corners of the area that they share (vertices of either in the face of the other, and edges that cross). Places at the same
//! point are one. Among places in one plane with gaps that are linear over it, the ones inside their hull are left out, because the others decide
//! about them.

use crate::distances::doubles::take_doubles;
use crate::distances::inner::without_inner;
use crate::distances::near_pairs::near_pairs;
use crate::distances::nearest::{nearest, spans_plane};
use crate::features::arcs::points_on_faces;
use crate::features::both::{Both, Candidate};
use crate::features::crossing::beside_tangent;
use crate::features::feature::{FeatureId, Part, contact_features, features, inside, lies_near, part};
use crate::features::guesses::guesses;
use crate::features::lens::points_of_arcs;
use crate::features::meet::{Guess, meet};
use crate::features::slab::reaching;
use crate::shapes::convex::Core;
use nalgebra::Vector3;

/// Places that are nearer than this to each other are one, relative to the size.
pub const SAME: f64 = 1e-7;
/// Normals of one flat contact differ by less than this.
const PARALLEL: f64 = 1e-6;
/// A crossing is within its edges by more than this part of the size: where corners lie on edges, it is one by roundings.
const INSIDE: f64 = 1e-13;
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
    // Two points are one pair of features.
    if let (Core::Polytope(a), Core::Polytope(b)) = (&both.a.core, &both.b.core)
        && let ([_], [_]) = (&a.vertices[..], &b.vertices[..])
    {
        return vec![closest];
    }
    places_in_slabs(both, closest, near, f64::INFINITY)
}

/// The same in slabs that are at most this deep (m); the closest points have to be nearer than `near`.
pub fn places_in_slabs(both: &Both, closest: Candidate, near: f64, deepest: f64) -> Vec<Candidate> {
    let mut found = candidates(both, &closest, [near, deepest]);
    if found.is_empty() {
        found.push(closest);
    }
    leave_corners(both, &mut found);
    found
}

/// Leaves one place at each point and the corners of the hull, and beside them the crossings that part from them.
pub(super) fn leave_corners(both: &Both, found: &mut Vec<Candidate>) {
    let same = SAME * both.a.size.min(both.b.size);
    let doubles = take_doubles(found, same, [both.a.radius, both.b.radius]);
    without_inner(found, 1e-12 * both.size());
    let left = found.len();
    for crossing in doubles {
        let near = |other: &&Candidate| (other.points[0] - crossing.points[0]).norm() <= same;
        let parts = |other: &Candidate| is_crossing_beside(both, other, &crossing);
        let is_left = found.iter().any(|other| other.features == crossing.features);
        if !is_left && found[..left].iter().filter(near).any(parts) {
            found.push(crossing);
        }
    }
}

/// Whether a place at the same point as an earlier one parts from it, as where a corner has just passed an edge: the crossing of a side of the corner with
/// the edge, beside the corner on the face of the edge or the crossing of its other side.
fn is_crossing_beside(both: &Both, earlier: &Candidate, crossing: &Candidate) -> bool {
    let side = |side: usize| match (&[both.a, both.b][side].core, crossing.features[side], earlier.features[side]) {
        (Core::Polytope(polytope), FeatureId::Edge(edge), other) => {
            let point = if side == 0 { crossing.points[0] } else { both.of_b(&crossing.points[1]) };
            let within = inside(&[both.a, both.b][side].core, crossing.features[side], &point) > INSIDE * both.size();
            let ends = polytope.edges[edge as usize].ends;
            within.then(|| match other {
                FeatureId::Vertex(vertex) => ends.contains(&(vertex as usize)),
                FeatureId::Edge(other) => {
                    other != edge && polytope.edges[other as usize].ends.iter().any(|end| ends.contains(end))
                }
                _ => false,
            })
        }
        _ => None,
    };
    let parallel = (earlier.normal - crossing.normal).norm() <= PARALLEL;
    parallel && matches!((side(0), side(1)), (Some(a), Some(b)) if a != b)
}

/// All pairs of features that pass the tests of the module.
fn candidates(both: &Both, closest: &Candidate, [near, deepest]: [f64; 2]) -> Vec<Candidate> {
    let (a, b) = (&both.a.core, &both.b.core);
    let (size, radii) = (both.size(), both.a.radius + both.b.radius);
    let normal = closest.normal;
    let own = both.rotation.tr_mul(&normal);
    let rounding = 1e-12 * size;
    let gap = closest.distance() - radii;
    let depth = (near - gap).min(deepest) + rounding;
    // Points in both slabs that face each other are no farther apart.
    let near = if deepest.is_finite() { near.min(gap + 2.0 * depth) } else { near };
    let tolerance = 10.0 * depth;
    let (least_a, least_b) = (a.support(&normal) - depth, b.support(&-own) - depth);
    // Cores that touch have no direction between two points: there a vertex that passes an edge counts as being over one face or the other.
    let sharp = closest.distance() <= 1e-9 * size;
    // Away from there it is over a face as far as contacts keep their features: over an edge the gap of a rounded shape opens anew.
    let share = if sharp { 1e-3 } else { 1e-9 };
    let outside = -(near.abs().min(share * size) + rounding);
    let at_closest = Guess { normal, point: closest.points[1], at_point: false };
    let mut found = Vec::new();
    let features = |core: &Core, normal: &Vector3<f64>, least: f64| {
        reaching(core, normal, least).unwrap_or_else(|| contact_features(core, normal, depth).collect())
    };
    let (mut of_a, mut of_b) = (features(a, &normal, least_a), features(b, &-own, least_b));
    points_of_arcs(both, &normal, &mut of_a, &mut of_b);
    points_on_faces(both, &normal, &mut of_a, &mut of_b);
    let of_a = within(a, &of_a, &normal, least_a);
    let of_b = within(b, &of_b, &-own, least_b);
    // Places of shapes that do not overlap are no farther apart than their gap may be, but for how far they may be outside their features.
    let overlap = closest.distance() < -1e-9 * size;
    let most = if overlap { f64::INFINITY } else { near.abs() + radii - CORNER * outside + 1e-9 * size };
    let parts_b: Vec<Part> =
        of_b.iter().map(|&(other, _)| part(b, other).moved(&both.rotation, &both.translation)).collect();
    for of_one in near_pairs(both, [&of_a, &of_b], most).chunk_by(|one, other| one.0 == other.0) {
        let (one, own_of_a) = of_a[of_one[0].0];
        let on_a = part(a, one);
        for &(_, number) in of_one {
            let (other, own_of_b) = of_b[number];
            let crosses = matches!(
                (one, other),
                (FeatureId::Rim(_), FeatureId::Edge(_)) | (FeatureId::Edge(_), FeatureId::Rim(_))
            );
            if !(crosses || own_of_a && own_of_b) {
                continue;
            }
            let on_b = &parts_b[number];
            if sharp && !spans_plane(&on_a, on_b) {
                continue;
            }
            for guess in guesses(&on_a, on_b, at_closest) {
                let Some((mut direction, points)) = meet(&on_a, on_b, &guess) else { continue };
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
                    leave_tangent(&mut candidate, [&on_a, on_b]);
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

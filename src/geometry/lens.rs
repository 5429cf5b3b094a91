//! Points that stand for the rims of discs that lie on each other beside their middles, or on a face that does not cover them.
//!
//! Discs of the radii R and r whose centres are D apart share a lens. Its border has an arc of each rim, about the direction of the other centre, with half the
//! angle
//!
//! ```text
//!     α = acos((D² + R² − r²)/(2 D R)),      β = acos((D² + r² − R²)/(2 D r))
//! ```
//!
//! Points at fixed angles may all be on one line, and a short arc may have none. So each arc has its own.
//!
//! Arcs of a rim that lie in a face, between two edges that cross the rim, have their middles as points if none of the fixed ones is in the face: a load
//! between the chord and the arc would have nothing to stand on. Where one is, others are added as loads need them.

use crate::both::Both;
use crate::convex::{Core, Cylinder};
use crate::feature::{FeatureId, Part, part, rim_point_towards};
use crate::plane::across;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Where the points of an arc are, as parts of half its angle: of one of less than a quarter of a turn on either side,
const SHORT: &[f64] = &[-0.9, 0.0, 0.9];
/// and of a longer one.
const LONG: &[f64] = &[-0.9, -0.3, 0.3, 0.9];

/// Arcs with less than this half angle (rad) have no point: that is at both of their ends,
const LEAST: f64 = 1e-6;
/// and arcs beside one edge with less than this have none, because the middle of the edge touches there ([`crate::crossing`]).
const LEAST_BESIDE: f64 = 1e-2;

/// The end whose rim has points among these features.
fn flat_end(features: &[FeatureId]) -> Option<u32> {
    features.iter().find_map(|feature| match feature {
        FeatureId::RimPoint { end, .. } => Some(*end),
        _ => None,
    })
}

/// Half the angle of the arc of a rim that lies in another disc, a distance of the centres (m) away; `None` if it is the whole rim or nothing.
fn half_angle(radius: f64, other: f64, apart: f64) -> Option<f64> {
    let crosses = apart > (radius - other).abs() && apart < radius + other;
    crosses
        .then(|| ((apart * apart + radius * radius - other * other) / (2.0 * apart * radius)).clamp(-1.0, 1.0).acos())
}

/// Replaces the points of the rims of two discs that lie on each other, where these cross, by such of their arcs; `normal` points from the first to the second.
pub fn points_of_arcs(both: &Both, normal: &Vector3<f64>, of_a: &mut Vec<FeatureId>, of_b: &mut Vec<FeatureId>) {
    let (a, b) = match (&both.a.core, &both.b.core) {
        (Core::Cylinder(a), Core::Cylinder(b)) => (a, b),
        _ => return points_on_faces(both, normal, [of_a, of_b]),
    };
    let (Some(end_a), Some(end_b)) = (flat_end(of_a), flat_end(of_b)) else { return };
    let between = both.of_b(&b.rim_centre(end_b as usize)) - a.rim_centre(end_a as usize);
    let level = between - normal * normal.dot(&between);
    let apart = level.norm();
    let (Some(alpha), Some(beta)) = (half_angle(a.radius, b.radius, apart), half_angle(b.radius, a.radius, apart))
    else {
        return;
    };
    let along = level / apart;
    let across = normal.cross(&along);
    let replace = |of: &mut Vec<FeatureId>,
                   cylinder: &Cylinder,
                   end: u32,
                   half: f64,
                   turned: &dyn Fn(Vector3<f64>) -> Vector3<f64>| {
        of.retain(|feature| !matches!(feature, FeatureId::RimPoint { .. }));
        let parts = if half < std::f64::consts::FRAC_PI_2 { SHORT } else { LONG };
        of.extend(parts.iter().map(|part| {
            let (sine, cosine) = (part * half).sin_cos();
            rim_point_towards(cylinder, end, &turned(along * cosine + across * sine))
        }));
    };
    replace(of_a, a, end_a, alpha, &|direction| direction);
    replace(of_b, b, end_b, beta, &|direction| -both.rotation.tr_mul(&direction));
}

/// Adds points of the arcs of a rim that lie in a face of the other shape and have none.
fn points_on_faces(both: &Both, normal: &Vector3<f64>, of: [&mut Vec<FeatureId>; 2]) {
    let cores = [&both.a.core, &both.b.core];
    let placed = |side: usize, point: Vector3<f64>| if side == 0 { point } else { both.of_b(&point) };
    let turned = |side: usize, along: Vector3<f64>| if side == 0 { along } else { both.turned(&along) };
    for (side, features) in of.into_iter().enumerate() {
        let (Core::Cylinder(cylinder), Core::Polytope(polytope)) = (cores[side], cores[1 - side]) else { continue };
        let Some(end) = flat_end(features) else { continue };
        // The face that is against the end.
        let out = if side == 0 { -normal } else { *normal };
        let faces = polytope.faces.iter().map(|face| (face, turned(1 - side, face.normal).dot(&out)));
        let Some((face, _)) = faces.max_by(|one, other| one.1.total_cmp(&other.1)) else { continue };
        let centre = placed(side, cylinder.rim_centre(end as usize));
        let (x, y) = across(normal);
        let flat = |point: Vector3<f64>| Vector2::new(x.dot(&(point - centre)), y.dot(&(point - centre)));
        let corners: Vec<Vector2<f64>> =
            face.corners.iter().map(|&corner| flat(placed(1 - side, polytope.vertices[corner]))).collect();
        let angle = |place: Vector2<f64>| place.y.atan2(place.x).rem_euclid(TAU);
        let mut crossings: Vec<(f64, usize)> = Vec::new();
        for (edge, (from, to)) in corners.iter().zip(corners.iter().cycle().skip(1)).enumerate() {
            let along = to - from;
            let (square, half) = (along.norm_squared(), along.dot(from));
            let root = (half * half - square * (from.norm_squared() - cylinder.radius.powi(2))).sqrt();
            let parts = [-half - root, -half + root].map(|sum| sum / square);
            let on = parts.iter().filter(|part| (0.0..=1.0).contains(*part));
            crossings.extend(on.map(|part| (angle(from + along * *part), edge)));
        }
        crossings.sort_by(|one, other| one.0.total_cmp(&other.0));
        let known = features.iter().filter_map(|&name| match (name, part(cores[side], name)) {
            (FeatureId::RimPoint { .. }, Part::Point(at)) => Some(angle(flat(placed(side, at)))),
            _ => None,
        });
        let known: Vec<f64> = known.collect();
        // On one side of all edges, whichever way round they go seen along the normal.
        let is_inside = |angle: f64| {
            let at = Vector2::new(angle.cos(), angle.sin()) * cylinder.radius;
            let sides =
                || corners.iter().zip(corners.iter().cycle().skip(1)).map(|(from, to)| (to - from).perp(&(at - from)));
            sides().all(|side| side > 0.0) || sides().all(|side| side < 0.0)
        };
        if known.iter().any(|angle| is_inside(*angle)) {
            continue;
        }
        for (place, &(from, edge)) in crossings.iter().enumerate() {
            let (next, last) = crossings[(place + 1) % crossings.len()];
            let least = if edge == last { LEAST_BESIDE } else { LEAST };
            let arc = if place + 1 < crossings.len() { next - from } else { next + TAU - from };
            if is_inside(from + 0.5 * arc) && arc > 2.0 * least {
                let (sine, cosine) = (from + 0.5 * arc).sin_cos();
                let towards = x * cosine + y * sine;
                let own = if side == 0 { towards } else { both.rotation.tr_mul(&towards) };
                features.push(rim_point_towards(cylinder, end, &own));
            }
        }
    }
}

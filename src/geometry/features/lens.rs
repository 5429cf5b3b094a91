//! Points that stand for the rims of two discs that lie on each other beside their middles.
//!
//! Discs of the radii R and r whose centres are D apart share a lens. Its border has an arc of each rim, about the direction of the other centre,
//! with half the angle
//!
//! ```text
//!     α = acos((D² + R² − r²)/(2 D R)),      β = acos((D² + r² − R²)/(2 D r))
//! ```
//!
//! Points at fixed angles may all be on one line, and a short arc may contain no fixed point. So each arc has its own.

use crate::features::both::Both;
use crate::features::feature::{FeatureId, rim_point_towards};
use crate::shapes::convex::{Core, Cylinder};
use nalgebra::Vector3;

/// The points of an arc, as parts of half its angle, for an arc of less than a quarter of a turn on either side.
const SHORT: &[f64] = &[-0.9, 0.0, 0.9];
/// The points of a longer arc, as parts of half its angle.
const LONG: &[f64] = &[-0.9, -0.3, 0.3, 0.9];

/// The end whose rim has points among these features.
pub fn flat_end(features: &[FeatureId]) -> Option<u32> {
    features.iter().find_map(|feature| match feature {
        FeatureId::RimPoint { end, .. } => Some(*end),
        _ => None,
    })
}

/// Half the angle of the arc of a rim that lies in another disc, a distance of the centres (m) away; `None` if the rims do not cross.
fn half_angle(radius: f64, other: f64, apart: f64) -> Option<f64> {
    let crosses = apart > (radius - other).abs() && apart < radius + other;
    crosses
        .then(|| ((apart * apart + radius * radius - other * other) / (2.0 * apart * radius)).clamp(-1.0, 1.0).acos())
}

/// Replaces the points of the rims of two discs that lie on each other, where these cross, by such of their arcs; `normal` points from the first to
/// the second.
pub fn points_of_arcs(both: &Both, normal: &Vector3<f64>, of_a: &mut Vec<FeatureId>, of_b: &mut Vec<FeatureId>) {
    let (Core::Cylinder(a), Core::Cylinder(b)) = (&both.a.core, &both.b.core) else { return };
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

//! How an edge crosses the rim of a cylinder: the form of their gap that suits it, as features of a joint.
//!
//! The unit vector along the edge is f, the axis of the rim k, and m is the direction from the axis to the touching place. The edge goes through the
//! plane of the rim as fast as `k·f` and out of the rim as fast as `m·f`. The larger of both decides which pair it is
//! ([`catena_mechanism::motion::contact_geometry`]): line–rim if it is steep, rim–line if it is flat. A closed contact changes to the other pair once
//! its own is a third of it, not where both are equal, so that it does not change to and fro.

use crate::features::feature::{FeatureId, Part};
use catena_mechanism::description::contact::Feature;
use nalgebra::Vector3;

/// A gap up to this part of the radius of the rim is the gap of the pair, which equals the distance at a closed contact only.
const CLOSED: f64 = 1e-6;
/// An edge that leaves the tangent of the rim by less than this (rad) has no certain point on it.
const TANGENT: f64 = 1e-3;
/// An edge in the plane of the rim that leaves the tangent by less than this has no certain point either: both its places run together ever faster,
/// and the force of each of them is a difference.
const FLAT_TANGENT: f64 = 1e-2;
/// An edge is in the plane of a rim if it leaves it by less than this (rad).
const FLAT: f64 = 1e-6;
/// An edge that is nearer than this (rad) to the plane of a rim, or to its tangent, is in it.
const LEVEL: f64 = 1e-13;
/// A pair is kept until it suits less than the other by this factor.
const KEPT: f64 = 3.0;

/// Normals whose cosine with the normal of a cap is more than this are along it.
const OUT_OF_CAP: f64 = 1.0 - 1e-6;

/// How an edge and a rim are a pair of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Whether the line is the first feature.
    pub line_first: bool,
    /// Whether the line points the other way than the edge.
    pub reversed: bool,
    /// The sign of n.
    pub side: f64,
}

/// A line and a circle.
struct LineAndCircle<'p> {
    /// Ends of the line (m).
    ends: &'p [Vector3<f64>; 2],
    /// Centre (m) and axis of the circle.
    circle: [&'p Vector3<f64>; 2],
    /// m.
    radius: f64,
    line_first: bool,
}

/// A line and a circle among two parts.
fn line_and_circle(parts: [&Part; 2]) -> Option<LineAndCircle<'_>> {
    let (ends, centre, axis, radius, line_first) = match parts {
        [Part::Line(ends, 0.0), Part::Circle(centre, axis, radius)] => (ends, centre, axis, *radius, true),
        [Part::Circle(centre, axis, radius), Part::Line(ends, 0.0)] => (ends, centre, axis, *radius, false),
        _ => return None,
    };
    Some(LineAndCircle { ends, circle: [centre, axis], radius, line_first })
}

/// f, k·f and m·f, with m where the rim has a point (m).
fn slopes(
    ends: &[Vector3<f64>; 2],
    [centre, axis]: [&Vector3<f64>; 2],
    point: &Vector3<f64>,
) -> (Vector3<f64>, [f64; 2]) {
    let along = (ends[1] - ends[0]).normalize();
    let arm = point - centre;
    let out = (arm - axis * axis.dot(&arm)).try_normalize(0.0).unwrap_or_default();
    (along, [axis.dot(&along), out.dot(&along)])
}

/// The least angle (rad) with the tangent at which an edge is steep to the plane of the rim by this sine has a certain point on it.
fn least_angle(steep: f64) -> f64 {
    if steep.abs() < FLAT { FLAT_TANGENT } else { TANGENT }
}

/// How two parts in one frame are such a pair, with their points (m), the normal from the first to the second, and their gap (m). `None` if they are
/// not: other features, an edge along the rim, or parts that are too far from each other.
pub fn crossing(parts: [&Part; 2], points: &[Vector3<f64>; 2], normal: &Vector3<f64>, gap: f64) -> Option<Crossing> {
    let LineAndCircle { ends, circle, radius, line_first } = line_and_circle(parts)?;
    let point = points[usize::from(line_first)];
    let (along, [steep, outwards]) = slopes(ends, circle, &point);
    if gap.abs() > CLOSED * radius || steep.abs().max(outwards.abs()) < least_angle(steep) {
        return None;
    }
    let steeper = steep.abs() >= outwards.abs();
    // A flat line points outwards.
    let reversed = !steeper && outwards < 0.0;
    let along = if reversed { -along } else { along };
    let [centre, axis] = circle;
    let out = (point - centre) / radius;
    let across = out * axis.dot(&along) - axis * out.dot(&along);
    let from_line = if line_first { *normal } else { -normal };
    let from_first = if steeper { from_line } else { -from_line };
    Some(Crossing { line_first: steeper, reversed, side: if across.dot(&from_first) < 0.0 { -1.0 } else { 1.0 } })
}

/// The point that stands for the part of an edge on a cap beside the tangent of its rim, if the edge is about to leave the cap or has just come over
/// it: the two places at which it crosses the rim run together there. It is the middle of both, so that the edge leaves with it exactly.
pub struct Beside {
    /// As a part of the way from the first to the second end.
    pub part: f64,
    /// On the edge and on the plane of the cap (m).
    pub points: [Vector3<f64>; 2],
    /// Along the axis of the circle, either way.
    pub normal: Vector3<f64>,
}

/// That point of a sharp edge and the circle of a rim, if the edge is along the tangent of the rim at their place (m) and their normal is along the
/// axis.
pub fn beside_tangent(parts: [&Part; 2], points: &[Vector3<f64>; 2], normal: &Vector3<f64>) -> Option<Beside> {
    let LineAndCircle { ends, circle: [centre, axis], radius, line_first } = line_and_circle(parts)?;
    let (along, [steep, outwards]) = slopes(ends, [centre, axis], &points[usize::from(line_first)]);
    let up = axis.dot(normal);
    if steep.abs().max(outwards.abs()) >= least_angle(steep) || up.abs() < OUT_OF_CAP {
        return None;
    }
    let level = along - axis * steep;
    let way = -level.dot(&(ends[0] - centre)) / level.norm_squared();
    let at = ends[0] + along * way;
    let height = axis.dot(&(at - centre));
    let part = way / (ends[1] - ends[0]).norm();
    let inside = (at - centre).norm_squared() <= radius * radius + height * height;
    let on = inside && (0.0..=1.0).contains(&part);
    on.then_some(Beside { part, points: [at, at - axis * height], normal: axis * up.signum() })
}

/// How far two features that cross so are from another place (m): where the other pair suits better, or where the edge lies on the cap or on the side
/// beside the rim, and would go into the cylinder beyond. Negative there; infinite for other features. The parts, in one frame, have these names and
/// points (m).
pub fn off_crossing(
    features: &[Feature; 2],
    names: [FeatureId; 2],
    parts: [&Part; 2],
    points: &[Vector3<f64>; 2],
) -> f64 {
    let Some(found) = line_and_circle(parts) else { return f64::INFINITY };
    let LineAndCircle { ends, circle, radius, line_first } = found;
    let rim = usize::from(line_first);
    let (_, [steep, outwards]) = slopes(ends, circle, &points[rim]);
    let least = 0.5 * least_angle(steep);
    // Out of the cap, which is at the end of the axis or at its start.
    let steep = if names[rim] == FeatureId::Rim(0) { -steep } else { steep };
    let (own, other) = match features {
        [Feature::Line { .. }, Feature::Rim { .. }] => (steep, outwards),
        [Feature::Rim { .. }, Feature::Line { .. }] => (outwards, steep),
        _ => return f64::INFINITY,
    };
    // Outside of the cylinder an edge that goes outwards goes down, and one that goes up inwards. One that is level but for rounding goes neither
    // way.
    let outside = if other.abs() <= LEVEL { f64::INFINITY } else { -own.signum() * other };
    radius * (own.abs() - other.abs() / KEPT).min(own.abs() - least).min(outside)
}

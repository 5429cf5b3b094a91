//! Rims against round features, and against rims: the form of their gaps as features of a joint, and the distance of a place from another form.
//!
//! A rim is touched with normals n out of it that are between the outward normal k of its cap and the direction m from the axis to the place. A line
//! that lies across the disc of the rim has two places, and goes outwards at its own. Let c be the distance of the line from the axis, ρ the radius
//! of the rim, and β the sine of the angle of the line with the axis. Then this is so for c < ρβ² ([`catena_mechanism::motion::rim_and_line`]). If
//! one of two rims has the steeper tangent to the plane of the other, it goes through that plane. If both are flatter than the angle between them,
//! seen along both axes, they pass each other ([`catena_mechanism::motion::level_rims`]). A closed contact keeps its form somewhat longer than
//! another one would be given it, so that it does not change to and fro.

use crate::features::feature::{FeatureId, Part};
use catena_mechanism::description::contact::{Feature, Grip, LEVEL, Touch};
use catena_mechanism::ground::smooth::Triple;
use catena_mechanism::motion::contact_geometry::{Contact, Placed, contact};
use catena_mechanism::motion::level_rims::level_rims;
use nalgebra::Vector3;

/// A gap up to this part of the radius of a rim is the gap of two rims, which equals the distance at a closed contact only.
const CLOSED: f64 = 1e-6;
/// Tangents that leave the plane of the other rim by less than this (rad) have no certain point on it.
const TANGENT: f64 = 1e-3;
/// Two rims are nearly in one plane from this cosine of their axes on.
const PARALLEL: f64 = 0.95;
/// Two such rims keep their form down to this cosine.
const STILL_PARALLEL: f64 = 0.9;
/// A pair of rims is kept until the other order suits better by this factor.
const KEPT: f64 = 3.0;
/// The largest c over ρβ² of a line that counts as going outwards.
const ACROSS: f64 = 1.2;
/// A line with c above ρβ² must go outwards by more than this part of β.
const OUTWARDS: f64 = 0.1;
/// A contact keeps that form up to this c over ρβ².
const STILL_ACROSS: f64 = 1.4;

/// How two parts are a pair of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// Whether the second part is the first feature.
    pub swapped: bool,
    /// Which parts point the other way in the joint: lines, and the axes of circles.
    pub reversed: [bool; 2],
    /// See [`catena_mechanism::description::contact::Touch::side`].
    pub side: f64,
}

impl Form {
    /// Parts as they are, or exchanged.
    pub fn plain(swapped: bool) -> Self {
        Form { swapped, reversed: [false; 2], side: 1.0 }
    }
}

/// The unit vector from the axis of a circle to a point.
fn outward(centre: &Vector3<f64>, axis: &Vector3<f64>, point: &Vector3<f64>) -> Vector3<f64> {
    let arm = point - centre;
    (arm - axis * axis.dot(&arm)).try_normalize(0.0).unwrap_or_default()
}

/// c/(ρβ²) and β of a line and a circle; the first is infinite for a line along the axis.
fn across(
    centre: &Vector3<f64>,
    axis: &Vector3<f64>,
    radius: f64,
    ends: &[Vector3<f64>; 2],
) -> (f64, f64, Vector3<f64>) {
    let along = (ends[1] - ends[0]).normalize();
    let product = along.cross(axis);
    let beta = product.norm();
    let distance = product.dot(&(ends[0] - centre)).abs();
    (if beta > 0.0 { distance / (radius * beta.powi(3)) } else { f64::INFINITY }, beta, along)
}

/// The form of a circle and a round line that touch at a point (m) of the circle.
pub fn beside(circle: &Part, ends: &[Vector3<f64>; 2], point: &Vector3<f64>, swapped: bool) -> Option<Form> {
    let Part::Circle(centre, axis, radius) = circle else { return None };
    let (part, beta, along) = across(centre, axis, *radius, ends);
    let outwards = outward(centre, axis, point).dot(&along);
    let side = part < 1.0 || (part < ACROSS && outwards.abs() > OUTWARDS * beta);
    let reversed = side && outwards < 0.0;
    let reversed = if swapped { [reversed, false] } else { [false, reversed] };
    Some(Form { swapped, reversed, side: if side { 1.0 } else { 0.0 } })
}

/// The sines of the angles at which two circles that touch at a point (m) pass each other: of the tangent of the first with the plane of the second,
/// of the tangent of the second with the plane of the first, and, with its sign, of the angle of the tangents seen along both axes, which point to
/// one side.
fn slants(centres: [&Vector3<f64>; 2], [k, l]: [&Vector3<f64>; 2], point: &Vector3<f64>) -> [f64; 3] {
    let [m, u] = [outward(centres[0], k, point), outward(centres[1], l, point)];
    let middle = (k + l).try_normalize(0.0).unwrap_or_default();
    [k.cross(&m).dot(l), l.cross(&u).dot(k), middle.dot(&m.cross(&u))]
}

/// The form of two circles that touch at a point (m), with the normal from the first to the second and a gap (m); `None` where they are tangent or
/// too far from each other. Circles nearly in one plane have the form of [`catena_mechanism::motion::level_rims`].
pub fn rims(parts: [&Part; 2], point: &Vector3<f64>, normal: &Vector3<f64>, gap: f64) -> Option<Form> {
    let [Part::Circle(one, k, radius), Part::Circle(other, l, other_radius)] = parts else { return None };
    let tangents = [k.cross(&outward(one, k, point)), l.cross(&outward(other, l, point))];
    let opposite = k.dot(l) < 0.0;
    let upright = if opposite { -l } else { *l };
    let [_, _, level] = slants([one, other], [k, &upright], point);
    // Slopes of the first at the plane of the second, and of the second at the plane of the first.
    let [first, second] = [tangents[0].dot(l), tangents[1].dot(k)];
    let steep = first.abs().max(second.abs());
    if gap.abs() > CLOSED * radius.min(*other_radius) || steep.max(level.abs()) < TANGENT {
        return None;
    }
    if level.abs() > steep && k.dot(&upright) > PARALLEL {
        // Among the two places at which they pass each other, the one at the point.
        let off = |down: bool| {
            let [k, l] = [*k, upright].map(|axis| Triple((if down { -axis } else { axis }).into()));
            let passing = level_rims([*radius, *other_radius], 1.0, Triple((other - one).into()), [k, l]);
            (one + Vector3::from(passing.point.0) - point).norm()
        };
        let down = off(true) < off(false);
        let reversed = [down, down != opposite];
        let [t, u] = [0, 1].map(|i: usize| if reversed[i] { -tangents[i] } else { tangents[i] });
        let side = if t.cross(&u).dot(normal) < 0.0 { -LEVEL } else { LEVEL };
        return Some(Form { swapped: false, reversed, side });
    }
    let swapped = first.abs() > second.abs();
    let reversed = if swapped { [first > 0.0, false] } else { [false, second > 0.0] };
    let [t, u] = [0, 1].map(|i: usize| if reversed[i] { -tangents[i] } else { tangents[i] });
    // Exchanged, the normal and the product both change their signs.
    let side = if t.cross(&u).dot(normal) < 0.0 { -1.0 } else { 1.0 };
    Some(Form { swapped, reversed, side })
}

/// The features of a place that has a rim as the joint has it, and where they are.
pub struct Joined {
    /// In the order of the joint.
    pub features: [Feature; 2],
    /// See [`Touch::side`].
    pub side: f64,
    /// Origins (m) and axes.
    pub placed: [[Vector3<f64>; 2]; 2],
}

/// A rim and the feature that touches it.
pub struct Meeting {
    /// Normal from the first feature to the second.
    pub normal: Vector3<f64>,
    /// On both cores (m).
    pub points: [Vector3<f64>; 2],
    /// Difference of the form of the gap from another one (m); infinite without a form.
    pub off_form: f64,
}

impl Joined {
    /// The place at which a rim touches a round feature, or another rim; `None` for other features.
    pub fn meeting(&self) -> Option<Meeting> {
        let [rim, partner] = self.features;
        let Feature::Rim { radius } = rim else { return None };
        let touch = Touch { features: self.features, side: self.side, grip: Grip::Rolls };
        let pairing = touch.pairing()?;
        let placed =
            |[origin, axis]: [Vector3<f64>; 2]| Placed { origin: Triple(origin.into()), axis: Triple(axis.into()) };
        let [a, b] = self.placed.map(placed);
        let Contact { gap, normal, point } = contact::<f64>(pairing, self.side, a, b, || b.axis);
        let (normal, point) = (Vector3::from(normal.0), Vector3::from(point.0));
        let [[centre, axis], [other, along]] = &self.placed;
        let off_form = match partner {
            Feature::Line { radius: round } if round > 0.0 => {
                let (part, _, _) = across(centre, axis, radius, &[*other, other + along]);
                let outwards = outward(centre, axis, &point).dot(along);
                radius * if self.side > 0.0 { (STILL_ACROSS - part).min(outwards) } else { part - 1.0 }
            }
            Feature::Point { .. } => f64::INFINITY,
            Feature::Rim { .. } => {
                let upright = if axis.dot(along) < 0.0 { -along } else { *along };
                let [first, second, level] = slants([centre, other], [axis, &upright], &point).map(f64::abs);
                let is_level = self.side.abs() == LEVEL;
                let (own, rest) = if is_level { (level, first.max(second)) } else { (second, first.max(level)) };
                let tilted = if is_level { axis.dot(along).abs() - STILL_PARALLEL } else { f64::INFINITY };
                radius * (own - rest / KEPT).min(own - 0.5 * TANGENT).min(tilted)
            }
            Feature::Line { .. } | Feature::Plane | Feature::Ellipsoid { .. } | Feature::Hollow { .. } => return None,
        };
        Some(Meeting { normal, points: [point - normal * gap, point + normal * pairing.radius], off_form })
    }
}

/// How far a place on a rim is from the cap and from the side (m): the height of its partner over both, if that is at a distance (m) along the normal
/// out of the rim; negative beyond.
pub fn off_rim(part: &Part, name: FeatureId, point: &Vector3<f64>, normal: &Vector3<f64>, distance: f64) -> f64 {
    let Part::Circle(centre, axis, _) = part else { return f64::INFINITY };
    let up = if name == FeatureId::Rim(0) { -axis } else { *axis };
    distance * normal.dot(&outward(centre, axis, point)).min(normal.dot(&up))
}

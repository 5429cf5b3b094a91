//! Rims whose cylinders tilt in a plane: one point of them touches.
//!
//! A rim about k with the centre c and the radius ρ on a plane with the normal n touches at its lowest point, in the direction −m from its axis:
//!
//! ```text
//!     m = n − (n·k) k                    |m|: sine of the tilt
//!     ṁ = ν − (ν·k) k,  ν = n × ω        in the frame of the rim, with its angular velocity ω relative to the plane
//! ```
//!
//! While ṁ is along m the lowest point is the same point of the material. It stands for the rim then, because its gap is smooth where the rim comes
//! down flat, m = 0, and the gap of the rim is not. The opposite point is open, and meets the plane there with an impact. If the tilt leaves the
//! plane of k and m, the rim itself touches again ([`crate::geometry::PairGeometry::margin`]). A rim at rest that does not lie flat has no ṁ: its
//! accelerations decide, once they are known. A wheel that stands begins to roll, and a point of its material would hold it in its place.
//!
//! Source: G. W. Housner, The behavior of inverted pendulum structures during earthquakes, Bulletin of the Seismological Society of America 53
//! (1963).

use crate::geometry::FeatureId;
use crate::instant::holding::touching::{Contact, Touching};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::contact::Feature;
use crate::mechanism::motion::kinematics::BodyAcceleration;
use nalgebra::Vector3;

/// A rim at rest lies flat up to this sine of its tilt.
const FLAT: f64 = 1e-3;
/// A tilt is in a plane if what leaves the plane is less than this part of its rate.
const PLANAR: f64 = 1e-9;
/// A tilt that is accelerated by less than this part of gravity and of the largest acceleration is a rounding: the rim is left alone.
const ROUNDED: f64 = 1e-12;

/// A rim on a plane, and how it tilts.
struct Tilt {
    /// The direction of m, and its length: the sine of the tilt.
    towards: Vector3<f64>,
    sine: f64,
    axis: Vector3<f64>,
    normal: Vector3<f64>,
    radius: f64,
}

impl Tilt {
    /// For a contact; `None` if it has no rim on a plane, or if the rim lies flat.
    fn of(contact: &Contact, bodies: &[BodyState]) -> Option<Tilt> {
        let [Feature::Plane, Feature::Rim { radius }] = contact.joint.touch.features else { return None };
        let along = |end: &Attachment| end.place(bodies).1.column(2).into_owned();
        let (normal, axis) = (along(&contact.joint.a), along(&contact.joint.b));
        let level = normal - axis * normal.dot(&axis);
        Some(Tilt { towards: level.try_normalize(0.0)?, sine: level.norm(), axis, normal, radius })
    }

    /// ṁ of a turning relative to the plane, times the radius: its length, and the part that leaves the plane of k and m.
    fn rates(&self, turning: &Vector3<f64>) -> [f64; 2] {
        let moved = self.normal.cross(turning);
        let rate = moved - self.axis * moved.dot(&self.axis);
        [self.radius * rate.norm(), self.radius * rate.dot(&self.axis.cross(&self.towards)).abs()]
    }
}

/// How fast the rim of a contact turns relative to the plane.
fn turning(contact: &Contact, bodies: &[BodyState]) -> Vector3<f64> {
    contact.joint.b.on(bodies).angular_velocity - contact.joint.a.on(bodies).angular_velocity
}

/// The contact at the point of a rim that touches, if the rim tilts in a plane; speeds up to `rest` [m/s] are zero.
pub(crate) fn touching_point(
    touching: &Touching,
    contact: &Contact,
    bodies: &[BodyState],
    rest: f64,
) -> Option<Contact> {
    let tilt = Tilt::of(contact, bodies)?;
    let [rate, leaves] = tilt.rates(&turning(contact, bodies));
    let planar = leaves <= PLANAR * rate || leaves <= rest;
    let planar = planar && (rate > rest || tilt.sine <= FLAT);
    if planar { touching.on_rim(contact, &-tilt.towards, bodies) } else { None }
}

/// The same for a rim at rest that begins to tilt with accelerations of all bodies. A wheel that stands begins to roll, which leaves the plane, and one
/// on which no force acts stays a rim. Speeds up to `rest` [m/s] are zero, and accelerations of roundings of the `largest` one [m/s²].
pub(crate) fn point_that_begins(
    touching: &Touching,
    contact: &Contact,
    bodies: &[BodyState],
    accelerations: &[BodyAcceleration],
    (rest, largest): (f64, f64),
) -> Option<Contact> {
    let tilt = Tilt::of(contact, bodies)?;
    if tilt.rates(&turning(contact, bodies))[0] > rest {
        return None;
    }
    let of = |end: &Attachment| end.body.map_or(Vector3::zeros(), |body| accelerations[body].1);
    let [rate, leaves] = tilt.rates(&(of(&contact.joint.b) - of(&contact.joint.a)));
    let planar = rate > ROUNDED * largest && leaves <= PLANAR * rate;
    if planar { touching.on_rim(contact, &-tilt.towards, bodies) } else { None }
}

/// If a rim comes down flat and one of its points has touched alone, the found points of the rim are replaced: by that point, by the opposite one,
/// which meets the plane, and by the points between. Points beside them would not rest and part in pairs.
pub(crate) fn land_opposite(touching: &Touching, before: &[&Contact], found: &mut Vec<Contact>, bodies: &[BodyState]) {
    let [pivot] = before else { return };
    let end = pivot.flat_end();
    if end.is_none() || found.iter().all(|contact| contact.flat_end() != end) {
        return;
    }
    let Some(from) = turn(pivot) else { return };
    // Some points may be beside a bordered face. On a mesh, another triangle may be below, which has one of the points that were found.
    let at = |part: f64| {
        let known = || std::iter::once(*pivot).chain(found.iter().filter(|contact| contact.flat_end() == end));
        let same = |known: &Contact| touching.turned(known, (from + part - turn(known)?).rem_euclid(1.0), bodies);
        known().filter_map(same).map(|(contact, _)| contact).find(|contact| touching.margin(contact, bodies) >= 0.0)
    };
    let others: Vec<Contact> = [0.25, 0.5, 0.75].into_iter().filter_map(at).collect();
    found.retain(|contact| contact.flat_end() != end);
    found.push((*pivot).clone());
    found.extend(others);
}

/// Position of the point of a contact on its rim, in turns; `None` if it has no such point.
fn turn(contact: &Contact) -> Option<f64> {
    match (contact.features.a, contact.features.b) {
        (FeatureId::RimPoint { turn, .. }, _) | (_, FeatureId::RimPoint { turn, .. }) => Some(f64::from_bits(turn)),
        _ => None,
    }
}

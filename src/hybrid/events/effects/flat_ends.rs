//! Ends of cylinders that lie flat: the rim touches where it would go below its plane.
//!
//! A plane carries a disc with any force whose centre of pressure is in the disc, `|(M_x, M_y)| ≤ r N`: the wrenches of all points of its rim
//! together. A few points of the rim stand for it. Rates and accelerations of the gaps of a flat rim are
//!
//! ```text
//!     φ̇(θ), φ̈(θ) = c + A cos(θ − θ₀)            θ along the rim; least at θ₀ + π:  c − |A|
//! ```
//!
//! If an impact or a decision leaves the least of them below zero, the answer for these points is not the answer for the disc: another point is
//! added, and the problem solved anew. The point is the one towards the centre of pressure of the forces that would hold the disc, because it begins
//! to tip there. If that point exists already, the point with the least value is added. Added points that carry no force are removed again. So the
//! disc is exact, with as many points as it needs.
//!
//! Source: R. Hettich, K. O. Kortanek, Semi-infinite programming: theory, methods, and applications, SIAM Review 35 (1993), section 7 (exchange
//! methods).

use crate::instant::holding::touching::{Contact, RimOf, Touching};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::TouchJoint;
use crate::mechanism::motion::touches::{tangents, touch_motion};
use nalgebra::Vector3;

/// Points of a rim nearer than this to each other are one, relative to its radius.
const SAME: f64 = 1e-6;
/// Centres of pressure nearer than this to a point of the rim that is there are at that point, relative to the radius.
const THERE: f64 = 1e-3;
/// An end is flat if its rim rises by less than this part of its radius.
const FLAT: f64 = 2e-9;
/// Rounds in which points towards centres of pressure are added: next to other contacts those depend on the points that there are.
const TOWARDS_PRESSURE: usize = 2;
/// If the centre of pressure is nearer than this to the middle of the disc, relative to the radius, the disc is far from tipping.
const MIDDLE: f64 = 0.3;

/// Contacts whose normals have at least this cosine are in one plane.
const IN_PLANE: f64 = 1.0 - 1e-12;

/// A flat end and its geometry.
struct FlatEnd<'c> {
    /// Contacts at points of its rim.
    points: Vec<&'c Contact>,
    /// Centre of the disc, in the world (m), and its radius (m).
    centre: Vector3<f64>,
    radius: f64,
    tangents: [Vector3<f64>; 2],
}

/// The question to the rims of a list of contacts.
pub(crate) struct Asked<'s, V: Fn(&TouchJoint) -> f64> {
    pub touching: &'s Touching,
    pub bodies: &'s [BodyState],
    /// φ̇ or φ̈ of a point.
    pub value: V,
    /// Values down to this are zero.
    pub least: f64,
    /// Number of rounds that have added points before.
    pub round: usize,
    /// Whether the point towards the centre of pressure is wanted in any case.
    pub pressed: bool,
}

impl<V: Fn(&TouchJoint) -> f64> Asked<'_, V> {
    /// The points that the rims of these contacts lack, whose normal forces are known; empty if the answer is right for the discs.
    pub fn lacking(&self, contacts: &[&Contact], pressures: &[f64]) -> Vec<Contact> {
        let mut ends: Vec<RimOf> = Vec::new();
        for contact in contacts {
            ends.extend(contact.flat_end().filter(|end| !ends.contains(end)));
        }
        let own = |end: &RimOf| contacts.iter().copied().filter(|contact| contact.flat_end() == Some(*end)).collect();
        let of_pair = |end: &RimOf| {
            let with_pressures = contacts.iter().copied().zip(pressures.iter().copied());
            with_pressures.filter(|(contact, _)| contact.pair == end.pair).collect::<Vec<_>>()
        };
        ends.iter().filter_map(|end| self.lacking_point(own(end), &of_pair(end))).collect()
    }

    /// The point that the rim with these contacts lacks, of a pair with these contacts and normal forces (N).
    fn lacking_point(&self, points: Vec<&Contact>, of_pair: &[(&Contact, f64)]) -> Option<Contact> {
        let Asked { touching, bodies, .. } = *self;
        let end = FlatEnd::new(points, touching, bodies)?;
        let arms: Vec<Vector3<f64>> = (0..3).map(|third| end.arm(f64::from(third) / 3.0)).collect();
        let values = arms.iter().map(|arm| Some((self.value)(&touching.on_rim(end.points[0], arm, bodies)?.joint)));
        let values: Vec<f64> = values.collect::<Option<_>>()?;
        let slope: Vector3<f64> = arms.iter().zip(&values).map(|(arm, value)| arm * (value * 2.0 / 3.0)).sum();
        let lowest = values.iter().sum::<f64>() / 3.0 - slope.norm();
        let pressed = end.towards_pressure(of_pair, bodies);
        let wanted = if lowest < self.least {
            let new = pressed.filter(|towards| self.round < TOWARDS_PRESSURE && !end.has(towards, THERE, bodies));
            new.or_else(|| (-slope).try_normalize(0.0))?
        } else if self.pressed {
            pressed?
        } else {
            return None;
        };
        if end.has(&wanted, SAME, bodies) {
            return None;
        }
        // Another triangle of a mesh may be below.
        let found = end.points.iter().filter_map(|known| touching.on_rim(known, &wanted, bodies));
        found.into_iter().find(|contact| touching.margin(contact, bodies) >= 0.0)
    }
}

impl<'c> FlatEnd<'c> {
    fn new(points: Vec<&'c Contact>, touching: &Touching, bodies: &[BodyState]) -> Option<Self> {
        let first = *points.first()?;
        let normal = touch_motion(&first.joint, bodies).normal;
        let tangents = tangents(&normal);
        let at = |towards: &Vector3<f64>| {
            touching.on_rim(first, towards, bodies).map(|contact| touch_motion(&contact.joint, bodies).point)
        };
        let (one, other) = (at(&tangents[0])?, at(&-tangents[0])?);
        let (centre, radius) = (0.5 * (one + other), 0.5 * (one - other).norm());
        // A tilted end that stands on one point of its rim lacks no points.
        let rises = normal.dot(&(one - other)).hypot(normal.dot(&(at(&tangents[1])? - centre)) * 2.0);
        (rises <= FLAT * radius).then_some(FlatEnd { points, centre, radius, tangents })
    }

    /// The direction of a point of the rim, from its angle in turns.
    fn arm(&self, turn: f64) -> Vector3<f64> {
        let (sine, cosine) = (std::f64::consts::TAU * turn).sin_cos();
        self.tangents[0] * cosine + self.tangents[1] * sine
    }

    /// Whether there is a point in this direction, to within a part of the radius.
    fn has(&self, towards: &Vector3<f64>, within: f64, bodies: &[BodyState]) -> bool {
        let place = self.centre + towards * self.radius;
        let near =
            |contact: &&Contact| (touch_motion(&contact.joint, bodies).point - place).norm() <= within * self.radius;
        self.points.iter().any(near)
    }

    /// The direction of the centre of pressure of all contacts of its pair that are in its plane, whichever feature has them: if a disc lies on
    /// another, the points of both rims carry it. `None` if no contact presses, or if the centre is near the middle.
    fn towards_pressure(&self, of_pair: &[(&Contact, f64)], bodies: &[BodyState]) -> Option<Vector3<f64>> {
        let normal = self.tangents[0].cross(&self.tangents[1]);
        let mut sum = 0.0;
        let mut moment = Vector3::zeros();
        for (contact, pressure) in of_pair {
            let touch = touch_motion(&contact.joint, bodies);
            let arm = touch.point - self.centre;
            let height = normal.dot(&arm);
            if touch.normal.dot(&normal).abs() < IN_PLANE || height.abs() > SAME * self.radius {
                continue;
            }
            sum += pressure;
            moment += (arm - normal * height) * *pressure;
        }
        (sum > 0.0 && moment.norm() > MIDDLE * self.radius * sum).then(|| moment.normalize())
    }
}

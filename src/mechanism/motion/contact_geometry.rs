//! Gap, normal and point of contact of two features, from the frames of both.
//!
//! The features ([`crate::description::contact`]) have the origins `a`, `b` (m) and the axes `z_a`, `z_b`; `d = b − a`, R is the sum of the radii and
//! r the radius of the second feature (m):
//!
//! ```text
//!     point–point:   n = d/|d|                        φ = |d| − R                p = b − r n
//!     plane–point:   n = z_a                          φ = n·d − R                p = b − r n
//!     line–point:    q = d − (d·z_a) z_a,  n = q/|q|  φ = |q| − R                p = b − r n
//!     line–line:     n = side (z_a × z_b)/|z_a × z_b| φ = n·d − R                p = b + t z_b − r n
//!     plane–rim:     n = z_a,  m = n − (n·z_b) z_b    φ = n·d − ρ |m|            p = b − ρ m/|m|
//!     hollow–point:  n = −d/|d|                       φ = L − |d|                p = b
//!     plane–ellipsoid: n = z_a,  m_i = r_i² (n·e_i),  s = √Σ r_i² (n·e_i)²        φ = n·d − s    p = b − Σ m_i e_i / s
//! ```
//!
//! with the semi-axes r_i (m) of an ellipsoid along the axes e_i of its frame, and the length L (m) of a rope.
//!
//! where `b + t z_b` is the point of the second line that is nearest to the first: `t = ((d·z_a) e − d·z_b)/(1 − e²)`, `e = z_a·z_b`.
//! n points from a to b. A rim that lies flat in the plane (m = 0) touches in all its points; p is its centre then.
//!
//! A line along f and a circle about k with the centre c and the radius ρ: where the line goes through the plane of the circle, or through the
//! cylinder above it, at w, the circle is next to it in the direction m from its axis. Across the line and the circle there
//!
//! ```text
//!     n = side (m (k·f) − k (m·f))/|…|
//!     line–rim:      w = a + s f, k·(w − c) = 0                       φ = (ρ − |w − c|) n·m      p = c + ρ m
//!     rim–line:      w = b + s f, |w − c − (k·(w − c)) k| = ρ, m·f > 0    φ = k·(w − c) n·k          p = w
//! ```
//!
//! Zero where the two touch, and with the gradient of the distance there: a gap of a contact that is closed. The first form is for lines that are
//! steep to the plane of the circle, the second for flat ones. The same holds for two circles about k_a and k_b, of which the second goes through the
//! plane of the first, downwards, at b + ρ_b u:
//!
//! ```text
//!     w = d + ρ_b u,   k_a·w = 0,   (k_b × u)·k_a < 0,   m = w/|w|
//!     n = side (k_a × m) × (k_b × u)/|…|              φ = (|w| − ρ_a) n·m        p = b + ρ_b u
//! ```
//!
//! Two circles that lie nearly in one plane have no such place that is certain: of them it is where they pass each other seen along both axes
//! ([`crate::motion::level_rims`]).
//!
//! A circle and a point, or a line, with a radius are apart where they touch: φ is the distance of their cores less the radius.
//!
//! ```text
//!     rim–point:     m = q/|q|, q = d − (d·k) k,  e = d − ρ m,  n = e/|e|        φ = |e| − r     p = b − r n
//!     rim–line:      e from the circle to its nearest point of the line ([`crate::motion::rim_and_line`])
//! ```

use crate::description::contact::{Cores, Pairing};
use crate::forces::point_spring::NO_LENGTH;
use crate::ground::smooth::{Smooth, Triple};
use crate::motion::level_rims::{LevelRims, level_rims};
use crate::motion::rim_and_line::{Beside, nearest};

/// The frame of a feature: its origin (m) and its axis.
#[derive(Clone, Copy, Debug)]
pub struct Placed<S> {
    /// P.
    pub origin: Triple<S>,
    /// z, a unit vector.
    pub axis: Triple<S>,
}

/// How two features are to each other.
#[derive(Clone, Copy, Debug)]
pub struct Contact<S> {
    /// φ (m).
    pub gap: S,
    /// n, from a to b.
    pub normal: Triple<S>,
    /// p (m), on the surface of b.
    pub point: Triple<S>,
}

/// The contact of two features, with [`crate::description::contact::Touch::side`]; `first_axis` is asked for the x axis of b where the feature of b is
/// not round about z.
#[inline(always)]
pub fn contact<S: Smooth>(
    pairing: Pairing,
    side: f64,
    a: Placed<S>,
    b: Placed<S>,
    first_axis: impl FnOnce() -> Triple<S>,
) -> Contact<S> {
    let apart = b.origin.minus(a.origin);
    let (reach, radius) = (S::constant(pairing.reach), S::constant(pairing.radius));
    let between = |vector: Triple<S>| {
        let length = length(vector);
        let normal = vector.times(length.reciprocal());
        Contact { gap: length - reach, normal, point: b.origin.minus(normal.times(radius)) }
    };
    match pairing.cores {
        Cores::Points => between(apart),
        Cores::LinePoint => between(apart.minus(a.axis.times(apart.dot(a.axis)))),
        Cores::PlanePoint => {
            let point = b.origin.minus(a.axis.times(radius));
            Contact { gap: apart.dot(a.axis) - reach, normal: a.axis, point }
        }
        Cores::Lines => {
            let across = a.axis.cross(b.axis);
            let per_length = length(across).reciprocal();
            let normal = across.times(per_length * S::constant(side));
            let cosine = a.axis.dot(b.axis);
            let along = (apart.dot(a.axis) * cosine - apart.dot(b.axis)) * per_length * per_length;
            let point = b.origin.plus(b.axis.times(along)).minus(normal.times(radius));
            Contact { gap: apart.dot(normal) - reach, normal, point }
        }
        Cores::PlaneRim(rim) => {
            let (normal, rim) = (a.axis, S::constant(rim));
            let down = normal.minus(b.axis.times(normal.dot(b.axis)));
            let length = length(down);
            let point = b.origin.minus(down.times(rim * length.reciprocal()));
            Contact { gap: apart.dot(normal) - rim * length, normal, point }
        }
        Cores::Hollow => {
            let length = length(apart);
            let normal = apart.times(S::constant(-1.0) * length.reciprocal());
            Contact { gap: reach - length, normal, point: b.origin }
        }
        Cores::PlaneEllipsoid(radii) => {
            let first = first_axis();
            let axes = [first, b.axis.cross(first), b.axis];
            let normal = a.axis;
            let tilts = axes.map(|axis| normal.dot(axis));
            let squares = radii.map(|radius| S::constant(radius * radius));
            let [x, y, z] = [0, 1, 2].map(|axis: usize| squares[axis] * tilts[axis]);
            let height = (x * tilts[0] + y * tilts[1] + z * tilts[2]).square_root();
            let arm = axes[0].times(x).plus(axes[1].times(y)).plus(axes[2].times(z)).times(height.reciprocal());
            Contact { gap: apart.dot(normal) - height, normal, point: b.origin.minus(arm) }
        }
        Cores::LineRim(rim) => {
            let (along, axis, rim) = (a.axis, b.axis, S::constant(rim));
            let arm = along.times(apart.dot(axis) * along.dot(axis).reciprocal()).minus(apart);
            let reached = length(arm);
            let out = arm.times(reached.reciprocal());
            let normal = across_rim(axis, along, out, side);
            Contact { gap: (rim - reached) * normal.dot(out), normal, point: b.origin.plus(out.times(rim)) }
        }
        Cores::RimLine(rim) => {
            let (along, axis, rim) = (b.axis, a.axis, S::constant(rim));
            let level = |vector: Triple<S>| vector.minus(axis.times(vector.dot(axis)));
            let (flat, off) = (level(along), level(apart));
            // The larger root of |off + s flat| = ρ: where the line goes outwards.
            let (square, half) = (flat.dot(flat), off.dot(flat));
            let root = (half * half - square * (off.dot(off) - rim * rim)).square_root();
            let arm = apart.plus(along.times((root - half) * square.reciprocal()));
            let height = arm.dot(axis);
            let out = arm.minus(axis.times(height)).times(rim.reciprocal());
            let normal = across_rim(axis, along, out, side);
            Contact { gap: height * normal.dot(axis), normal, point: a.origin.plus(arm) }
        }
        Cores::RimPoint(rim) => {
            let level = apart.minus(a.axis.times(apart.dot(a.axis)));
            between(apart.minus(level.times(S::constant(rim) * length(level).reciprocal())))
        }
        Cores::RimBesideLine(rim) => {
            let Beside { between: off, foot } = nearest(rim, side, apart, a.axis, b.axis);
            let length = length(off);
            let normal = off.times(length.reciprocal());
            let point = a.origin.plus(foot).minus(normal.times(radius));
            Contact { gap: length - reach, normal, point }
        }
        Cores::LevelRims(rim, other) => {
            let LevelRims { gap, normal, point } = level_rims([rim, other], side.signum(), apart, [a.axis, b.axis]);
            Contact { gap, normal, point: a.origin.plus(point) }
        }
        Cores::Rims(rim, other) => {
            let (rim, other) = (S::constant(rim), S::constant(other));
            // Two directions in the plane of the second circle: up from the plane of the first, and along it.
            let up = a.axis.minus(b.axis.times(a.axis.dot(b.axis)));
            let per_slope = length(up).reciprocal();
            let up = up.times(per_slope);
            let cosine = apart.dot(a.axis) * per_slope * other.reciprocal();
            let sine = (S::constant(1.0) - cosine * cosine).square_root();
            let out = b.axis.cross(up).times(sine).minus(up.times(cosine));
            let arm = apart.plus(out.times(other));
            let reached = length(arm);
            let towards = arm.times(reached.reciprocal());
            let normal = a.axis.cross(towards).cross(b.axis.cross(out));
            let normal = normal.times(length(normal).reciprocal() * S::constant(side));
            Contact { gap: (reached - rim) * normal.dot(towards), normal, point: a.origin.plus(arm) }
        }
    }
}

/// The unit normal across a line and the tangent of a circle about an axis, at a point in a direction out of the axis.
#[inline(always)]
fn across_rim<S: Smooth>(axis: Triple<S>, along: Triple<S>, out: Triple<S>, side: f64) -> Triple<S> {
    let normal = out.times(axis.dot(along)).minus(axis.times(out.dot(along)));
    normal.times(length(normal).reciprocal() * S::constant(side))
}

/// The length of a vector, never zero.
#[inline(always)]
fn length<S: Smooth>(vector: Triple<S>) -> S {
    (vector.dot(vector) + S::constant(NO_LENGTH)).square_root()
}

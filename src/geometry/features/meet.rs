//! The normal and the points of two features, in closed form or by Newton's method.
//!
//! n points from a to b, p lies on a and q on b. Features without bounds: whether p and q lie on them is asked of
//! [`crate::features::feature::inside`].
//!
//! | pair | n | p, q |
//! |---|---|---|
//! | plane (o, z)–point | z | projection, point |
//! | hollow (c, L)–point | c − q | p = the point of the sphere beyond q |
//! | plane–ellipsoid | z | q = the point that is farthest along −z |
//! | plane–circle (c, k, ρ) | z | q = c − ρ m, m = the part of z across k, normalised |
//! | line–line (e, f, radii r) | ±(e × f)/\|e × f\| | the feet, moved by r along n |
//! | line–point | from the axis to the point | |
//! | point–point | q − p | |
//! | circle–point | ±(q − p) | p = c + ρ q⊥/\|q⊥\| |
//! | circle–line | ±(q − p) | q = o + t f with (q − p) · f = 0: [`catena_mechanism::motion::rim_and_line`] |
//! | circle–circle | ±(q − p) | both tangents perpendicular to q − p: Newton on two angles |

use crate::features::feature::Part;
use crate::shapes::plane::across;
use catena_mechanism::ground::smooth::Triple;
use catena_mechanism::motion::rim_and_line::nearest;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Points at the same place by rounding, relative to the size of a feature: every normal that separates will do.
const COINCIDENT: f64 = 1e-13;
/// A point nearer to an axis than this part of its distance is on it.
const BESIDE: f64 = 1e-9;
/// Newton's method has converged long before.
const ITERATIONS: usize = 40;

/// A guess: it chooses among several solutions, and is the start of iterations.
#[derive(Clone, Copy, Debug)]
pub struct Guess {
    /// About n.
    pub normal: Vector3<f64>,
    /// About q (m).
    pub point: Vector3<f64>,
    /// Whether two circles are looked at from the point, and not from where they are farthest along the normal.
    pub at_point: bool,
}

/// Normal and points of two features; `None` for pairs without a unique normal: parallel lines, planes with planes or lines.
pub fn meet(a: &Part, b: &Part, guess: &Guess) -> Option<(Vector3<f64>, [Vector3<f64>; 2])> {
    let found = match (a, b) {
        (Part::Plane(at, normal), Part::Point(q)) => Some((*normal, [q - normal * normal.dot(&(q - at)), *q])),
        (Part::Plane(at, normal), Part::Circle(centre, axis, radius)) => {
            // Flat on the plane any point of the circle will do: the one next to where the contact is thought to be. Cross products are used because
            // 1 − (k · n)² loses half of the digits near the axis, and the height of q with them.
            let slant = axis.cross(&normal.cross(axis));
            let towards = guess.point - centre;
            // Above the middle that one has no direction but roundings, which may be along the axis.
            let beside = axis * axis.dot(&towards) - towards;
            let inward = slant.try_normalize(1e-12).or_else(|| beside.try_normalize(BESIDE * towards.norm()));
            let q = centre - inward.unwrap_or_else(|| across(axis).0) * *radius;
            Some((*normal, [q - normal * normal.dot(&(q - at)), q]))
        }
        (Part::Plane(at, normal), Part::Ellipsoid(ellipsoid)) => {
            let q = ellipsoid.support_point(&-normal);
            Some((*normal, [q - normal * normal.dot(&(q - at)), q]))
        }
        (Part::Ellipsoid(_), Part::Plane(..)) => {
            let back = Guess { normal: -guess.normal, ..*guess };
            meet(b, a, &back).map(|(normal, [q, p])| (-normal, [p, q]))
        }
        (Part::Hollow(centre, radius), Part::Point(q)) => {
            let normal = (centre - q).try_normalize(0.0).unwrap_or(guess.normal);
            Some((normal, [centre - normal * *radius, *q]))
        }
        (Part::Point(_), Part::Hollow(..)) => {
            let back = Guess { normal: -guess.normal, ..*guess };
            meet(b, a, &back).map(|(normal, [q, p])| (-normal, [p, q]))
        }
        (Part::Ellipsoid(_) | Part::Hollow(..), _) | (_, Part::Ellipsoid(_) | Part::Hollow(..)) => None,
        (Part::Line(e, r), Part::Line(f, s)) => {
            line_line(e, f, &guess.normal).map(|(normal, [p, q])| (normal, [p + normal * *r, q - normal * *s]))
        }
        (Part::Line(e, r), Part::Point(q)) => {
            from_line(e, q, &guess.normal).map(|(normal, foot)| (normal, [foot + normal * *r, *q]))
        }
        (Part::Point(p), Part::Point(q)) => Some(((q - p).try_normalize(0.0).unwrap_or(guess.normal), [*p, *q])),
        (Part::Circle(centre, axis, radius), Part::Point(q)) => {
            let p = on_circle(centre, axis, *radius, q);
            let tangent = axis.cross(&(p - centre)).normalize();
            let off = (q - p).try_normalize(COINCIDENT * radius).unwrap_or(guess.normal);
            signed(&(off - tangent * tangent.dot(&off)), &guess.normal).map(|normal| (normal, [p, *q]))
        }
        (Part::Circle(centre, axis, radius), Part::Line(f, s)) => {
            circle_line(centre, axis, *radius, f, guess).map(|(normal, [p, q])| (normal, [p, q - normal * *s]))
        }
        (Part::Circle(..), Part::Circle(..)) => circle_circle(a, b, guess),
        (Part::Plane(..), Part::Plane(..) | Part::Line(..)) | (Part::Line(..), Part::Plane(..)) => None,
        (Part::Point(..) | Part::Line(..) | Part::Circle(..), _) => {
            let back = Guess { normal: -guess.normal, ..*guess };
            meet(b, a, &back).map(|(normal, [q, p])| (-normal, [p, q]))
        }
    };
    found.filter(|(normal, points)| normal.iter().chain(&points[0]).chain(&points[1]).all(|entry| entry.is_finite()))
}

/// The unit vector along another, on the side of a third.
fn signed(along: &Vector3<f64>, side: &Vector3<f64>) -> Option<Vector3<f64>> {
    let unit = along.try_normalize(0.0)?;
    Some(if unit.dot(side) < 0.0 { -unit } else { unit })
}

/// The product of two directions, square to both to rounding also where they are nearly parallel.
fn square_to(one: &Vector3<f64>, other: &Vector3<f64>) -> Vector3<f64> {
    let product = one.cross(other);
    let along = other.try_normalize(0.0).unwrap_or_default();
    let across = (one - along * along.dot(one)).try_normalize(0.0).unwrap_or_default();
    product - along * along.dot(&product) - across * across.dot(&product)
}

/// The common normal of two lines on the side of another, and its feet; `None` if the lines are parallel.
fn line_line(
    one: &[Vector3<f64>; 2],
    other: &[Vector3<f64>; 2],
    side: &Vector3<f64>,
) -> Option<(Vector3<f64>, [Vector3<f64>; 2])> {
    let (e, f) = (one[1] - one[0], other[1] - other[0]);
    let product = e.cross(&f);
    let square = product.norm_squared();
    if square <= 1e-16 * e.norm_squared() * f.norm_squared() {
        return None;
    }
    let between = other[0] - one[0];
    let (s, t) = (between.cross(&f).dot(&product) / square, between.cross(&e).dot(&product) / square);
    Some((signed(&product, side)?, [one[0] + e * s, other[0] + f * t]))
}

/// The unit vector from a line to a point, perpendicular to the line, and the foot; of a point on the line the one that is about another.
fn from_line(
    line: &[Vector3<f64>; 2],
    point: &Vector3<f64>,
    side: &Vector3<f64>,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let along = (line[1] - line[0]).try_normalize(0.0)?;
    let foot = line[0] + along * along.dot(&(point - line[0]));
    let off = (point - foot).try_normalize(COINCIDENT * (line[1] - line[0]).norm()).unwrap_or(*side);
    // If two points nearly touch, their direction is uncertain, but never along the line.
    let normal = (off - along * along.dot(&off)).try_normalize(0.0)?;
    Some((normal, foot))
}

/// The point of a circle that is nearest to another point.
fn on_circle(centre: &Vector3<f64>, axis: &Vector3<f64>, radius: f64, point: &Vector3<f64>) -> Vector3<f64> {
    let arm = point - centre;
    let out = arm - axis * axis.dot(&arm);
    centre + out.try_normalize(0.0).unwrap_or_else(|| across(axis).0) * radius
}

/// Nearest points of a circle and a line. A line that goes out of the cylinder of the circle has one such place, and another one at its entry
/// ([`catena_mechanism::motion::rim_and_line`]): the one next to the point of the guess is taken.
fn circle_line(
    centre: &Vector3<f64>,
    axis: &Vector3<f64>,
    radius: f64,
    line: &[Vector3<f64>; 2],
    guess: &Guess,
) -> Option<(Vector3<f64>, [Vector3<f64>; 2])> {
    let f = (line[1] - line[0]).try_normalize(0.0)?;
    let triple = |vector: Vector3<f64>| Triple(vector.into());
    let place = |side: f64, f: Vector3<f64>| {
        let q =
            centre + Vector3::from(nearest(radius, side, triple(line[0] - centre), triple(*axis), triple(f)).foot.0);
        (on_circle(centre, axis, radius, &q), q)
    };
    let goes = |out: Vector3<f64>| {
        Some(place(1.0, out)).filter(|(p, q)| out.dot(&(p - centre)) > 0.0 && f.dot(&(q - p)).abs() <= 1e-9 * radius)
    };
    let away = |(_, q): &(Vector3<f64>, Vector3<f64>)| f.dot(&(q - guess.point)).abs();
    let (p, q) = match (goes(f), goes(-f)) {
        (Some(one), Some(other)) if away(&other) < away(&one) => other,
        (Some(one), _) | (None, Some(one)) => one,
        (None, None) => place(0.0, f),
    };
    // Perpendicular to the line and to the circle's tangent, as exact as these are apart; or along q − p, as exact as that is long.
    let product = square_to(&axis.cross(&(p - centre)), &f);
    let normal = if product.norm() > (q - p).norm() { product } else { q - p };
    signed(&normal, &guess.normal).or(Some(guess.normal)).map(|normal| (normal, [p, q]))
}

/// Nearest points of two circles: angles α, β with `d · p'(α) = 0` and `d · q'(β) = 0`, d = q − p.
fn circle_circle(a: &Part, b: &Part, guess: &Guess) -> Option<(Vector3<f64>, [Vector3<f64>; 2])> {
    let (Part::Circle(centre, axis, radius), Part::Circle(other, other_axis, other_radius)) = (a, b) else {
        return None;
    };
    let ((x, y), (u, v)) = (across(axis), across(other_axis));
    // The start is the pair of points of the circles that are farthest along the normal.
    let angle = |centre: &Vector3<f64>, out: Vector3<f64>, x: &Vector3<f64>, y: &Vector3<f64>| {
        let towards = guess.point - centre;
        let from_normal = !guess.at_point && x.dot(&out).hypot(y.dot(&out)) > 1e-3;
        let arm = if from_normal { out } else { towards };
        y.dot(&arm).atan2(x.dot(&arm))
    };
    let mut angles = Vector2::new(angle(centre, guess.normal, &x, &y), angle(other, -guess.normal, &u, &v));
    let at = |angles: &Vector2<f64>| {
        let ((sin_a, cos_a), (sin_b, cos_b)) = (angles.x.sin_cos(), angles.y.sin_cos());
        let arms = [(x * cos_a + y * sin_a) * *radius, (u * cos_b + v * sin_b) * *other_radius];
        (arms, [(y * cos_a - x * sin_a) * *radius, (v * cos_b - u * sin_b) * *other_radius])
    };
    let between = |arms: &[Vector3<f64>; 2]| other + arms[1] - centre - arms[0];
    for _ in 0..ITERATIONS {
        let (arms, turns) = at(&angles);
        let off = between(&arms);
        let gradient = Vector2::new(-off.dot(&turns[0]), off.dot(&turns[1]));
        let mixed = -turns[0].dot(&turns[1]);
        let (one, two) = (radius * radius + off.dot(&arms[0]), other_radius * other_radius - off.dot(&arms[1]));
        // Downhill also where the distance bends down: no curvature below a small positive one.
        let least = 0.5 * (one + two) - (0.25 * (one - two).powi(2) + mixed * mixed).sqrt();
        let lift = (1e-6 * radius * other_radius - least).max(0.0);
        let Some(inverse) = Matrix2::new(one + lift, mixed, mixed, two + lift).try_inverse() else { break };
        let newton = -(inverse * gradient);
        let mut step = newton * (0.3 / newton.norm().max(0.3));
        while between(&at(&(angles + step)).0).norm() > off.norm() && step.norm() > 1e-6 {
            step *= 0.5;
        }
        angles += step;
        if step.norm() <= 1e-17 {
            break;
        }
    }
    let (arms, [turn_a, turn_b]) = at(&angles);
    let (p, q) = (centre + arms[0], other + arms[1]);
    // As of a circle and a line.
    let product = square_to(&turn_a, &turn_b) / radius.max(*other_radius);
    let normal = if product.norm() > (q - p).norm() { product } else { q - p };
    signed(&normal, &guess.normal).or(Some(guess.normal)).map(|normal| (normal, [p, q]))
}

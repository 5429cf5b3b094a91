//! Starting points of the search for the nearest points of two features.
//!
//! An edge goes through a rim's cylinder at two places, and two rims cross at up to four: where either goes through the plane of the other.
//! [`crate::features::meet`] starts from each of them. The circles are (a, k, ρ) and (b, l, τ), d = b − a, and x, y are in the plane of the second, x
//! up from the plane of the first:
//!
//! ```text
//!     b + τ (x cos β + y sin β),        cos β = −k·d/(τ |k × l|)
//! ```

use crate::features::feature::Part;
use crate::features::meet::Guess;
use nalgebra::Vector3;

/// No pair has more.
const MOST: usize = 5;

/// Guesses for two features in one frame, of which this is one.
pub fn guesses(a: &Part, b: &Part, first: Guess) -> impl Iterator<Item = Guess> {
    let mut all = [Some(first), None, None, None, None];
    match (a, b) {
        (Part::Line(ends, _), Part::Circle(_, axis, _)) | (Part::Circle(_, axis, _), Part::Line(ends, _)) => {
            for (place, end) in all[1..].iter_mut().zip(ends) {
                // A normal along the axis does not determine the place on the rim.
                *place = Some(Guess { normal: *axis, point: *end, at_point: true });
            }
        }
        (Part::Circle(..), Part::Circle(..)) => {
            let through = [(a, b), (b, a)].map(|(plane, circle)| through_plane(plane, circle));
            let points = through.into_iter().flatten().flatten();
            for (place, point) in all[1..MOST].iter_mut().zip(points) {
                *place = Some(Guess { point, at_point: true, ..first });
            }
        }
        _ => {}
    }
    all.into_iter().flatten()
}

/// The points at which a circle goes through the plane of another (m).
fn through_plane(plane: &Part, circle: &Part) -> Option<[Vector3<f64>; 2]> {
    let (Part::Circle(origin, normal, _), Part::Circle(centre, axis, radius)) = (plane, circle) else { return None };
    let up = normal - axis * axis.dot(normal);
    let slope = up.norm();
    let cosine = -normal.dot(&(centre - origin)) / (radius * slope);
    if cosine.is_nan() || cosine.abs() > 1.0 {
        return None;
    }
    let (x, sine) = (up / slope, (1.0 - cosine * cosine).sqrt());
    let y = axis.cross(&x);
    Some([sine, -sine].map(|sine| centre + (x * cosine + y * sine) * *radius))
}

/// Whether a circle and a point, or an edge, are certainly farther from each other than a length (m): the edge lies beyond that length on one side of
/// the plane of the circle, within its cylinder, or outside of the ball about it. The distances from the plane, from the axis and from the centre are
/// bounded by the distances of the ends of the edge and of its nearest point.
pub fn is_beyond(a: &Part, b: &Part, length: f64) -> bool {
    let ((Part::Circle(centre, axis, radius), other) | (other, Part::Circle(centre, axis, radius))) = (a, b) else {
        return false;
    };
    let ends = match other {
        Part::Point(at) => [*at; 2],
        Part::Line(ends, 0.0) => *ends,
        _ => return false,
    };
    let arms = ends.map(|end| end - centre);
    let heights = arms.map(|arm| axis.dot(&arm));
    if heights[0].min(heights[1]) > length || heights[0].max(heights[1]) < -length {
        return true;
    }
    let from_axis = [0, 1].map(|end| (arms[end] - axis * heights[end]).norm());
    if from_axis[0].max(from_axis[1]) < radius - length {
        return true;
    }
    let along = arms[1] - arms[0];
    let part = (-arms[0].dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (arms[0] + along * part).norm() > radius + length
}

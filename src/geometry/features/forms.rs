//! Which pair of features of a joint two parts are, where they touch, and in which form.
//!
//! | parts | pair, first the one named first | n, besides what [`catena_mechanism::motion::contact_geometry`] says |
//! |---|---|---|
//! | plane, point, circle or ellipsoid; point, point; line, point; hollow, point | as they are | |
//! | line, line | as they are | side: the sign of (z₁ × z₂) · n |
//! | edge, circle | line–rim or rim–line | [`crate::features::crossing`] |
//! | circle, point or line with a radius; circle, circle | rim first | [`crate::features::rims`] |
//!
//! The other pairs have no form: a place of them is a point and its tangent plane, which has the right gap and the right rate at one instant only.

use crate::features::crossing::crossing;
use crate::features::feature::Part;
use crate::features::rims::{Form, beside, rims};
use nalgebra::Vector3;

/// The form of two parts in one frame, with radii about them (m), the points of their surfaces (m), the normal from the first to the second, and the
/// gap (m).
pub fn form(
    parts: [&Part; 2],
    radii: [f64; 2],
    points: &[Vector3<f64>; 2],
    normal: &Vector3<f64>,
    gap: f64,
) -> Option<Form> {
    let round = radii[0] + radii[1];
    match parts {
        [Part::Plane(..), Part::Point(_) | Part::Circle(..) | Part::Ellipsoid(_)]
        | [Part::Line(..) | Part::Hollow(..), Part::Point(_)]
        | [Part::Point(_), Part::Point(_)] => Some(Form::plain(false)),
        [Part::Point(_) | Part::Circle(..) | Part::Ellipsoid(_), Part::Plane(..)]
        | [Part::Point(_), Part::Line(..) | Part::Hollow(..)] => Some(Form::plain(true)),
        [Part::Line(e, _), Part::Line(f, _)] => {
            let across = (e[1] - e[0]).normalize().cross(&(f[1] - f[0]).normalize());
            Some(Form { side: if across.dot(normal) < 0.0 { -1.0 } else { 1.0 }, ..Form::plain(false) })
        }
        [Part::Circle(..), Part::Point(_)] if round > 0.0 => Some(Form::plain(false)),
        [Part::Point(_), Part::Circle(..)] if round > 0.0 => Some(Form::plain(true)),
        [Part::Circle(..), Part::Line(ends, own)] if round + own > 0.0 => beside(parts[0], ends, &points[0], false),
        [Part::Line(ends, own), Part::Circle(..)] if round + own > 0.0 => beside(parts[1], ends, &points[1], true),
        [Part::Circle(..), Part::Circle(..)] => rims(parts, &points[1], normal, gap),
        [Part::Line(..), Part::Circle(..)] | [Part::Circle(..), Part::Line(..)] => {
            let found = crossing(parts, points, normal, gap)?;
            let is_line = parts.map(|part| matches!(part, Part::Line(..)));
            let reversed = is_line.map(|is_line| is_line && found.reversed);
            Some(Form { swapped: found.line_first != is_line[0], reversed, side: found.side })
        }
        _ => None,
    }
}

//! Lines and markers of curves, in pixels.

use crate::canvas::Drawn;
use crate::style::{Dash, Look, Marker};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;

/// Lines across the data area.
pub(crate) const GRID: RGBColor = RGBColor(210, 210, 210);

/// Draws a curve through these pixels.
pub(crate) fn draw_line<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    pixels: &[(i32, i32)],
    look: &Look,
) -> Drawn<DB> {
    if pixels.len() < 2 {
        return Ok(());
    }
    let style = color(look).stroke_width(look.width);
    let (size, gap) = match look.dash {
        // Piece by piece: a path that folds back on itself is drawn with a long spike at the fold.
        Dash::Solid => {
            let mut pieces = pixels.windows(2);
            return pieces.try_for_each(|piece| area.draw(&PathElement::new(piece.to_vec(), style)));
        }
        Dash::Dashed => (9, 6),
        Dash::Dotted => (2, 5),
    };
    area.draw(&DashedPathElement::new(pixels.to_vec(), size, gap, style))
}

/// Draws a marker around a pixel.
pub(crate) fn draw_marker<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    (x, y): (i32, i32),
    look: &Look,
) -> Drawn<DB> {
    const RADIUS: f64 = 6.5;
    let corner = |turn: f64, radius: f64| {
        let angle = turn * std::f64::consts::TAU;
        (x + (radius * angle.sin()).round() as i32, y - (radius * angle.cos()).round() as i32)
    };
    let polygon = |corners: u32, first: f64| -> Vec<(i32, i32)> {
        (0..corners).map(|k| corner(first + f64::from(k) / f64::from(corners), RADIUS * 1.25)).collect()
    };
    let outline = match look.marker {
        Marker::Circle => {
            let fill = if look.filled { color(look) } else { WHITE };
            area.draw(&Circle::new((x, y), 6, fill.filled()))?;
            return area.draw(&Circle::new((x, y), 6, color(look).stroke_width(2)));
        }
        Marker::Cross | Marker::Plus => {
            let first = if look.marker == Marker::Plus { 0.0 } else { 0.125 };
            for turn in [first, first + 0.25] {
                let line = vec![corner(turn, RADIUS), corner(turn + 0.5, RADIUS)];
                area.draw(&PathElement::new(line, color(look).stroke_width(2)))?;
            }
            return Ok(());
        }
        Marker::None => return Ok(()),
        Marker::Square => polygon(4, 0.125),
        Marker::Diamond => polygon(4, 0.0),
        Marker::Triangle => polygon(3, 0.0),
        Marker::TriangleDown => polygon(3, 0.5),
        Marker::Star => {
            let radius = |k: u32| if k.is_multiple_of(2) { 1.5 * RADIUS } else { 0.6 * RADIUS };
            (0..10).map(|k| corner(f64::from(k) / 10.0, radius(k))).collect()
        }
    };
    let fill = if look.filled { color(look) } else { WHITE };
    area.draw(&Polygon::new(outline.clone(), fill.filled()))?;
    let closed: Vec<(i32, i32)> = outline.iter().chain(outline.first()).copied().collect();
    area.draw(&PathElement::new(closed, color(look).stroke_width(2)))
}

fn color(look: &Look) -> RGBColor {
    let (red, green, blue) = look.color;
    RGBColor(red, green, blue)
}

//! Drawing a [`Picture`] with plotters, the same for SVG and PNG.
//!
//! Axes are mapped to pixels here, logarithms included, so that every decade down to 1e-17 is where it belongs.

use super::axis::Axis;
use super::canvas::{Drawn, INK, QUIET, png_of, svg_of, text, text_at};
use super::error::ChartError;
use super::picture::{Figure, Picture, Series};
use super::style::{Dash, Look, Marker};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::path::Path;

/// Smallest size of the picture in pixels; a long legend makes it larger.
const SIZE: (i32, i32) = (1280, 800);
/// Edges of the data area.
const LEFT: i32 = 112;
const RIGHT: i32 = 948;
const TOP: i32 = 92;
/// From the data area to the lower edge of the picture.
const BELOW: i32 = 84;
/// Left edge of the legend.
const LEGEND: i32 = 976;

const GRID: RGBColor = RGBColor(210, 210, 210);
const FINE_GRID: RGBColor = RGBColor(240, 240, 240);

/// Size of a picture and of its data area, in pixels.
#[derive(Clone, Copy)]
struct Page {
    width: i32,
    height: i32,
    /// Edges of the data area.
    right: i32,
    top: i32,
    bottom: i32,
    /// Left edge of the legend.
    legend: i32,
    /// Size of the letters at the axes; those of the legend are a little smaller, those that name the axes larger.
    letters: i32,
}

/// Each of several pictures that share their horizontal axis.
const STACKED: Page = Page { width: SIZE.0, height: 312, right: 1020, top: 44, bottom: 276, legend: 1044, letters: 16 };

/// Height of the headline over several pictures, and of the last one, which names the axis.
const HEADLINE: i32 = 84;
const LAST_HEIGHT: i32 = 356;

impl Page {
    /// Room for everything in the legend.
    fn new(picture: &Picture) -> Self {
        let (right, bottom) = legend_extent(picture);
        let height = SIZE.1.max(bottom + 16);
        Page {
            width: SIZE.0.max(right + 16),
            height,
            right: RIGHT,
            top: TOP,
            bottom: height - BELOW,
            legend: LEGEND,
            letters: 20,
        }
    }

    fn size(self) -> (i32, i32) {
        (self.width, self.height)
    }

    fn at_x(self, fraction: f64) -> i32 {
        (f64::from(LEFT) + fraction * f64::from(self.right - LEFT)).round() as i32
    }

    fn at_y(self, fraction: f64) -> i32 {
        (f64::from(self.bottom) - fraction * f64::from(self.bottom - self.top)).round() as i32
    }

    /// Labels that fit one above the other.
    fn rows(self) -> i32 {
        (self.bottom - self.top) / (2 * self.letters + 8)
    }
}

/// The picture as SVG.
pub fn svg(picture: &Picture) -> Result<String, ChartError> {
    let page = Page::new(picture);
    svg_of(&picture.title, page.size(), |area| draw(area, page, picture))
}

/// The picture as a PNG file.
pub fn png(picture: &Picture, path: &Path) -> Result<(), ChartError> {
    let page = Page::new(picture);
    png_of(&picture.title, page.size(), path, |area| draw(area, page, picture))
}

/// Several pictures one below the other, as SVG.
pub fn stacked_svg(figure: &Figure) -> Result<String, ChartError> {
    svg_of(&figure.title, stacked_size(figure), |area| draw_stack(area, figure))
}

/// Several pictures one below the other, as a PNG file.
pub fn stacked_png(figure: &Figure, path: &Path) -> Result<(), ChartError> {
    png_of(&figure.title, stacked_size(figure), path, |area| draw_stack(area, figure))
}

fn stacked_size(figure: &Figure) -> (i32, i32) {
    let others = figure.pictures.len().saturating_sub(1) as i32;
    let page = Page { height: HEADLINE + STACKED.height * others + LAST_HEIGHT, ..STACKED };
    page.size()
}

fn draw_stack<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, figure: &Figure) -> Drawn<DB> {
    area.fill(&WHITE)?;
    text(area, &figure.title, (LEFT, 16), 28, HPos::Left, INK)?;
    text(area, &figure.subtitle, (LEFT, 54), 18, HPos::Left, QUIET)?;
    let (_, mut rest) = area.split_vertically(HEADLINE);
    for (index, picture) in figure.pictures.iter().enumerate() {
        let is_last = index + 1 == figure.pictures.len();
        let (panel, below) = rest.split_vertically(if is_last { LAST_HEIGHT } else { STACKED.height });
        draw(&panel, STACKED, picture)?;
        rest = below;
    }
    Ok(())
}

fn draw<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, page: Page, picture: &Picture) -> Drawn<DB> {
    area.fill(&WHITE)?;
    let points = || picture.panels.iter().flat_map(|panel| &panel.series).flat_map(|series| &series.points);
    let x = Axis::new(&picture.x, points().map(|point| point.0), 13);
    let y = Axis::new(&picture.y, points().map(|point| point.1), page.rows());
    for band in &picture.bands {
        let outside = if band.below.log10() > x.range.1 { page.right } else { LEFT };
        let edge = x.fraction(band.below).map_or(outside, |fraction| page.at_x(fraction));
        if edge > LEFT {
            area.draw(&Rectangle::new([(LEFT, page.top), (edge, page.bottom)], BLACK.mix(band.strength).filled()))?;
        }
    }
    draw_axes(area, page, &x, &y)?;
    if picture.subtitle.is_empty() {
        text(area, &picture.title, (LEFT, page.top - 28), page.letters + 2, HPos::Left, INK)?;
    } else {
        text(area, &picture.title, (LEFT, 20), 28, HPos::Left, INK)?;
        text(area, &picture.subtitle, (LEFT, 58), 18, HPos::Left, QUIET)?;
    }
    // Ours are drawn last, on top.
    for series in picture.panels.iter().rev().flat_map(|panel| panel.series.iter()) {
        draw_series(area, page, series, &x, &y)?;
    }
    draw_legend(area, page, picture)
}

fn draw_axes<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, page: Page, x: &Axis, y: &Axis) -> Drawn<DB> {
    let Page { right, top, bottom, letters, .. } = page;
    for &(line, strong) in &x.grid {
        let at = page.at_x(x.tick_fraction(line));
        area.draw(&PathElement::new(vec![(at, top), (at, bottom)], grid_color(strong)))?;
    }
    for &(line, strong) in &y.grid {
        let at = page.at_y(y.tick_fraction(line));
        area.draw(&PathElement::new(vec![(LEFT, at), (right, at)], grid_color(strong)))?;
    }
    area.draw(&Rectangle::new([(LEFT, top), (right, bottom)], INK.stroke_width(1)))?;
    for (tick, label) in &x.ticks {
        let at = page.at_x(x.tick_fraction(*tick));
        area.draw(&PathElement::new(vec![(at, bottom), (at, bottom + 6)], INK))?;
        text(area, label, (at, bottom + 11), letters, HPos::Center, INK)?;
    }
    for (tick, label) in &y.ticks {
        let at = page.at_y(y.tick_fraction(*tick));
        area.draw(&PathElement::new(vec![(LEFT - 6, at), (LEFT, at)], INK))?;
        text_at(area, label, (LEFT - 11, at), letters, (HPos::Right, VPos::Center), false)?;
    }
    text(area, &x.label, ((LEFT + right) / 2, bottom + letters + 24), letters + 2, HPos::Center, INK)?;
    text_at(area, &y.label, (16, (top + bottom) / 2), letters + 2, (HPos::Center, VPos::Top), true)
}

fn draw_series<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    page: Page,
    series: &Series,
    x: &Axis,
    y: &Axis,
) -> Drawn<DB> {
    let place = |&(a, b): &(f64, f64)| Some((page.at_x(x.fraction(a)?), page.at_y(y.fraction(b)?)));
    let pixels: Vec<(i32, i32)> = series.points.iter().filter_map(place).collect();
    draw_line(area, &pixels, &series.look)?;
    for &pixel in pixels.iter().step_by(series.markers_every.max(1)) {
        draw_marker(area, pixel, &series.look)?;
    }
    Ok(())
}

fn draw_line<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, pixels: &[(i32, i32)], look: &Look) -> Drawn<DB> {
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

fn draw_marker<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, (x, y): (i32, i32), look: &Look) -> Drawn<DB> {
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

/// Heights of the legend's rows in pixels: a heading, a curve, a line of a band and of a note, and the space after each group.
const HEADING: i32 = 34;
const CURVE: i32 = 27;
const BAND_LINE: i32 = 21;
const NOTE: i32 = 25;
const SPACE: i32 = 8;
/// Left edge of the words beside a sample, from the edge of the legend.
const WORDS: i32 = 54;

/// Right and lower edge of the legend in pixels.
fn legend_extent(picture: &Picture) -> (i32, i32) {
    // A letter of this font is on average 0.45 times as wide as its size says.
    let end = |words: &str, indent: i32, size: i32| LEGEND + indent + words.chars().count() as i32 * size * 23 / 50;
    let (mut right, mut bottom) = (LEGEND, TOP + SPACE);
    for panel in picture.panels.iter().filter(|panel| !panel.series.is_empty()) {
        bottom += HEADING + CURVE * panel.series.len() as i32 + SPACE;
        right = panel.series.iter().fold(right, |right, series| right.max(end(&series.label, WORDS, 18)));
    }
    for line in picture.bands.iter().flat_map(|band| band.label.lines()) {
        bottom += BAND_LINE;
        right = right.max(end(line, WORDS, 16));
    }
    bottom += SPACE * picture.bands.len() as i32 + NOTE * picture.notes.len() as i32;
    let right = picture.notes.iter().fold(right, |right, note| right.max(end(note, 0, 18)));
    (right, bottom)
}

fn draw_legend<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, page: Page, picture: &Picture) -> Drawn<DB> {
    let (legend, letters) = (page.legend, page.letters - 2);
    let mut y = page.top;
    for panel in picture.panels.iter().filter(|panel| !panel.series.is_empty()) {
        if !panel.heading.is_empty() {
            text(area, &panel.heading, (legend, y), letters, HPos::Left, QUIET)?;
            y += HEADING;
        }
        for series in &panel.series {
            let middle = y + letters / 2 - 7;
            draw_line(area, &[(legend, middle), (legend + 44, middle)], &series.look)?;
            draw_marker(area, (legend + 22, middle), &series.look)?;
            text_at(area, &series.label, (legend + WORDS, middle), letters, (HPos::Left, VPos::Center), false)?;
            y += CURVE - 18 + letters;
        }
        y += SPACE;
    }
    for band in &picture.bands {
        area.draw(&Rectangle::new([(legend, y), (legend + 44, y + 18)], BLACK.mix(band.strength).filled()))?;
        area.draw(&Rectangle::new([(legend, y), (legend + 44, y + 18)], GRID.stroke_width(1)))?;
        for line in band.label.lines() {
            text(area, line, (legend + WORDS, y), 16, HPos::Left, INK)?;
            y += BAND_LINE;
        }
        y += SPACE;
    }
    y += SPACE;
    for note in &picture.notes {
        text(area, note, (legend, y), letters, HPos::Left, INK)?;
        y += NOTE - 18 + letters;
    }
    Ok(())
}

fn grid_color(strong: bool) -> RGBColor {
    if strong { GRID } else { FINE_GRID }
}

fn color(look: &Look) -> RGBColor {
    let (red, green, blue) = look.color;
    RGBColor(red, green, blue)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::picture::{Panel, Scale};
    use crate::chart::style::look;

    /// A picture with so many curves of other programs.
    fn picture(curves: usize) -> Picture {
        let scale = |label: &str| Scale::Log { label: label.to_string(), least: 1e-12, most: 1e12 };
        let curve = |index: usize| Series {
            label: format!("a program with quite a long name, {index}"),
            look: look("other", index),
            points: vec![(1e-3, 1e-3), (1e-6, 1e-2)],
            markers_every: 1,
        };
        Picture {
            title: String::new(),
            subtitle: String::new(),
            x: scale("error"),
            y: scale("cost"),
            bands: Vec::new(),
            panels: vec![Panel { heading: "others".to_string(), series: (0..curves).map(curve).collect() }],
            notes: vec!["a note".to_string()],
        }
    }

    #[test]
    fn every_row_of_a_long_legend_is_inside_the_picture() {
        for curves in [1, 14, 40] {
            let text = svg(&picture(curves)).unwrap();
            let numbers = |name: &str| -> Vec<i32> {
                let attribute = format!(" {name}=\"");
                let parts = text.split(&attribute).skip(1);
                parts.filter_map(|part| part.split('"').next()?.parse().ok()).collect()
            };
            let height = numbers("height")[0];
            let lowest = numbers("y").into_iter().max().unwrap();
            assert!(lowest + 10 <= height, "{curves} curves: a row at {lowest} of {height} pixels");
            // Short legends leave the picture as it is.
            assert_eq!(height == SIZE.1, curves < 20, "{curves} curves, {height} pixels");
            // 36 letters of a font of size 18 take some 290 pixels.
            assert!(numbers("width")[0] >= LEGEND + WORDS + 290);
        }
    }
}

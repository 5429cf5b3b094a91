//! Drawing a [`Picture`] with plotters, the same for SVG and PNG.
//!
//! Axes are mapped to pixels here, logarithms included, so that every decade down to 1e-17 is where it belongs.

use crate::axis::Axis;
use crate::canvas::{Drawn, INK, QUIET, png_of, svg_of, text, text_at};
use crate::error::ChartError;
use crate::legend::{LEGEND, WORDS, draw_legend, legend_extent, words_end};
use crate::picture::{Figure, Picture, Series};
use crate::strokes::{GRID, draw_line, draw_marker};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::collections::BTreeSet;
use std::path::Path;

/// Smallest size of the picture in pixels; a long legend makes it larger.
const SIZE: (i32, i32) = (1280, 800);
/// Edges of the data area.
const LEFT: i32 = 112;
const RIGHT: i32 = 948;
const TOP: i32 = 92;
/// The distance from the data area to the lower edge of the picture.
const BELOW: i32 = 84;

/// Height of the ticks that mark values of the horizontal axis.
const MARK: i32 = 14;

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
    /// Size of the letters at the axes. The letters of the legend are a little smaller, the names of the axes larger.
    letters: i32,
}

/// Each of several pictures that share their horizontal axis; a long legend makes it wider.
const STACKED: Page = Page { width: SIZE.0, height: 312, right: 1020, top: 44, bottom: 276, legend: 1044, letters: 16 };

/// Height of the headline over several pictures, and of the last one, which names the axis.
const HEADLINE: i32 = 84;
const LAST_HEIGHT: i32 = 356;

impl Page {
    /// Room for everything in the legend.
    fn new(picture: &Picture) -> Self {
        let (right, bottom) = legend_extent(picture, TOP);
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

impl Figure {
    /// The figure as the text of an SVG file.
    ///
    /// # Errors
    /// [`ChartError::Draw`] if the drawing library fails.
    pub fn svg(&self) -> Result<String, ChartError> {
        stacked_svg(self)
    }

    /// Writes the figure as a PNG file.
    ///
    /// # Errors
    /// [`ChartError::Draw`] if the drawing library fails or the file cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<(), ChartError> {
        stacked_png(self, path)
    }
}

impl Picture {
    /// The picture as the text of an SVG file.
    ///
    /// # Errors
    /// [`ChartError::Draw`] if the drawing library fails.
    pub fn svg(&self) -> Result<String, ChartError> {
        svg(self)
    }

    /// Writes the picture as a PNG file.
    ///
    /// # Errors
    /// [`ChartError::Draw`] if the drawing library fails or the file cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<(), ChartError> {
        png(self, path)
    }
}

/// The picture as SVG.
fn svg(picture: &Picture) -> Result<String, ChartError> {
    let page = Page::new(picture);
    svg_of(&picture.title, page.size(), |area| draw(area, page, picture))
}

/// The picture as a PNG file.
fn png(picture: &Picture, path: &Path) -> Result<(), ChartError> {
    let page = Page::new(picture);
    png_of(&picture.title, page.size(), path, |area| draw(area, page, picture))
}

/// Several pictures one below the other, as SVG.
fn stacked_svg(figure: &Figure) -> Result<String, ChartError> {
    svg_of(&figure.title, stacked_size(figure), |area| draw_stack(area, figure))
}

/// Several pictures one below the other, as a PNG file.
fn stacked_png(figure: &Figure, path: &Path) -> Result<(), ChartError> {
    png_of(&figure.title, stacked_size(figure), path, |area| draw_stack(area, figure))
}

fn stacked_size(figure: &Figure) -> (i32, i32) {
    let others = figure.pictures.len().saturating_sub(1) as i32;
    (stacked_page(figure).width, HEADLINE + STACKED.height * others + LAST_HEIGHT)
}

/// Each picture of a figure, with room for the longest name in its legends.
fn stacked_page(figure: &Figure) -> Page {
    let panels = figure.pictures.iter().flat_map(|picture| &picture.panels);
    let names = panels.flat_map(|panel| &panel.series).map(|series| series.label.as_str());
    let end = names.map(|name| words_end(name, STACKED.legend + WORDS, STACKED.letters)).fold(0, i32::max);
    Page { width: STACKED.width.max(end + 16), ..STACKED }
}

fn draw_stack<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, figure: &Figure) -> Drawn<DB> {
    area.fill(&WHITE)?;
    text(area, &figure.title, (LEFT, 16), 28, HPos::Left, INK)?;
    text(area, &figure.subtitle, (LEFT, 54), 18, HPos::Left, QUIET)?;
    let page = stacked_page(figure);
    let (_, mut rest) = area.split_vertically(HEADLINE);
    for (index, picture) in figure.pictures.iter().enumerate() {
        let is_last = index + 1 == figure.pictures.len();
        let (panel, below) = rest.split_vertically(if is_last { LAST_HEIGHT } else { STACKED.height });
        draw(&panel, page, picture)?;
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
    draw_marks(area, page, &picture.marks, &x)?;
    draw_legend(area, (page.legend, page.top), page.letters - 2, picture)
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

/// Thin ticks that stand on the horizontal axis; of those at one pixel only one is drawn.
fn draw_marks<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, page: Page, marks: &[f64], x: &Axis) -> Drawn<DB> {
    let places: BTreeSet<i32> = marks.iter().filter_map(|&mark| x.fraction(mark)).map(|at| page.at_x(at)).collect();
    for at in places {
        area.draw(&PathElement::new(vec![(at, page.bottom - MARK), (at, page.bottom)], INK))?;
    }
    Ok(())
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

fn grid_color(strong: bool) -> RGBColor {
    if strong { GRID } else { FINE_GRID }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Panel, Scale};
    use crate::style::look;

    /// A picture with this number of curves of other programs.
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
            marks: Vec::new(),
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
            assert!(numbers("width")[0] >= LEGEND + crate::legend::WORDS + 290);
        }
    }
}

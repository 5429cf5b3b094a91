//! The legend beside a picture: how much room it takes, and drawing it.

use crate::canvas::{Drawn, INK, QUIET, text, text_at};
use crate::picture::Picture;
use crate::strokes::{GRID, draw_line, draw_marker};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Left edge of the legend.
pub(crate) const LEGEND: i32 = 976;
/// Heights of the legend's rows in pixels: a heading, a curve, a line of a band and of a note, and the space after each group.
const HEADING: i32 = 34;
const CURVE: i32 = 27;
const BAND_LINE: i32 = 21;
const NOTE: i32 = 25;
const SPACE: i32 = 8;
/// Left edge of the words beside a sample, from the edge of the legend.
pub(crate) const WORDS: i32 = 54;

/// Right edge of words of this size from their left edge on: a letter of this font is on average 0.45 times as wide as its size says.
pub(crate) fn words_end(words: &str, left: i32, size: i32) -> i32 {
    left + words.chars().count() as i32 * size * 23 / 50
}

/// Right and lower edge of the legend in pixels, where its upper edge is at `top`.
pub(crate) fn legend_extent(picture: &Picture, top: i32) -> (i32, i32) {
    let end = |words: &str, indent: i32, size: i32| words_end(words, LEGEND + indent, size);
    let (mut right, mut bottom) = (LEGEND, top + SPACE);
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

/// Draws it from its upper left corner on, with letters of this size.
pub(crate) fn draw_legend<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    (legend, top): (i32, i32),
    letters: i32,
    picture: &Picture,
) -> Drawn<DB> {
    let mut y = top;
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

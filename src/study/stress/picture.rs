//! The picture of a map: a panel for each method that can run any of it, difficulty upwards, shorter steps to the right.
//!
//! The colours are the palette of Okabe and Ito. Every verdict that is not good has a mark of its own besides, for prints without colour.

use crate::chart::Setting;
use crate::drawing::canvas::{Drawn, INK, QUIET, png_of, svg_of, text, text_at};
use crate::drawing::error::ChartError;
use crate::drawing::style;
use crate::drawing::style::{BLUE, ORANGE, SKY_BLUE, VERMILLION, YELLOW};
use crate::stress::cell::Verdict;
use crate::stress::map::Map;
use crate::stress::method::Method;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::path::Path;

const COLUMNS: usize = 3;
/// Edges of the panels and room between them, in pixels.
const LEFT: i32 = 150;
const TOP: i32 = 118;
const PANEL: (i32, i32) = (372, 226);
const GAP: (i32, i32) = (26, 76);
/// Cells of less width (pixels) have no line between them.
const NARROW: i32 = 6;
const RIGHT: i32 = 24;
const BELOW: i32 = 74;

/// The methods that can run at least one case, and the methods that can run no case.
fn able_and_not(map: &Map) -> (Vec<Method>, Vec<Method>) {
    let can =
        |method: &Method| map.cells.iter().any(|cell| cell.method == *method && cell.verdict != Verdict::NotApplicable);
    map.methods.into_iter().partition(can)
}

fn size(map: &Map) -> (i32, i32) {
    let rows = able_and_not(map).0.len().div_ceil(COLUMNS) as i32;
    let columns = COLUMNS as i32;
    (LEFT + columns * PANEL.0 + (columns - 1) * GAP.0 + RIGHT, TOP + rows * PANEL.1 + (rows - 1) * GAP.1 + BELOW + 36)
}

/// The picture as SVG.
///
/// # Errors
/// [`ChartError::Draw`] if the drawing library fails.
pub fn svg(map: &Map) -> Result<String, ChartError> {
    svg_of(map.thinned.problem.title, size(map), |area| draw(area, map))
}

/// Writes the picture as PNG.
///
/// # Errors
/// [`ChartError::Draw`] if the drawing library fails or the file cannot be written.
pub fn write_png(map: &Map, path: &Path) -> Result<(), ChartError> {
    png_of(map.thinned.problem.title, size(map), path, |area| draw(area, map))
}

fn draw<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, map: &Map) -> Drawn<DB> {
    area.fill(&WHITE)?;
    let problem = &map.thinned.problem;
    text(area, problem.title, (24, 16), 28, HPos::Left, INK)?;
    legend(area, 62)?;
    let (able, unable) = able_and_not(map);
    for (place, method) in able.into_iter().enumerate() {
        let (column, row) = ((place % COLUMNS) as i32, (place / COLUMNS) as i32);
        let corner = (LEFT + column * (PANEL.0 + GAP.0), TOP + row * (PANEL.1 + GAP.1));
        panel(area, map, method, corner, column == 0)?;
    }
    let (width, height) = size(map);
    text_at(area, problem.axis, (18, (TOP + height - BELOW - 36) / 2), 20, (HPos::Center, VPos::Top), true)?;
    text(area, "step [s], or tolerance [m]", ((LEFT + width - RIGHT) / 2, height - 76), 20, HPos::Center, INK)?;
    let judged: Vec<&str> = map
        .answers
        .iter()
        .zip(&map.thinned.places)
        .filter(|(answer, _)| answer.probes.is_none() && answer.refusal.is_none())
        .map(|(_, &place)| problem.difficulties[place])
        .collect();
    let judged = (!judged.is_empty())
        .then(|| format!("no two reference runs agree, so judged by the energy alone: {}", judged.join(", ")));
    let unable: Vec<String> = unable.into_iter().map(|method| method.label()).collect();
    let unable = (!unable.is_empty()).then(|| format!("not applicable to any cell: {}", unable.join("; ")));
    let notes: Vec<String> = judged.into_iter().chain(unable).collect();
    text(area, &notes.join(" · "), (24, height - 36), 16, HPos::Left, QUIET)
}

fn panel<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    map: &Map,
    method: Method,
    (left, top): (i32, i32),
    labelled: bool,
) -> Drawn<DB> {
    let settings = method.settings(&map.thinned.problem);
    let (columns, rows) = (settings.len(), map.thinned.places.len());
    let x = |column: usize| left + PANEL.0 * column as i32 / columns as i32;
    // Difficulty grows upwards.
    let y = |row: usize| top + PANEL.1 - PANEL.1 * row as i32 / rows as i32;
    text(area, &method.label(), (left, top - 25), 18, HPos::Left, INK)?;
    for row in 0..rows {
        for column in 0..columns {
            let Some(cell) = map.cell(method, row, column) else { continue };
            swatch(area, [(x(column), y(row + 1)), (x(column + 1), y(row))], cell.verdict)?;
        }
        if labelled {
            let label = map.thinned.problem.difficulties[map.thinned.places[row]];
            let middle = (y(row) + y(row + 1)) / 2;
            text_at(area, label, (left - 8, middle), 15, (HPos::Right, VPos::Center), false)?;
        }
    }
    area.draw(&Rectangle::new([(left, top), (left + PANEL.0, top + PANEL.1)], INK.stroke_width(1)))?;
    // As many labels as do not touch.
    let stride = columns.div_ceil(6);
    for (column, setting) in settings.iter().enumerate().step_by(stride) {
        let middle = (x(column) + x(column + 1)) / 2;
        let label = match setting {
            Setting::Step(step) => short(*step),
            Setting::Tolerance(tolerance) => format!("{tolerance:.0e}"),
        };
        area.draw(&PathElement::new(vec![(middle, top + PANEL.1), (middle, top + PANEL.1 + 4)], INK))?;
        text(area, &label, (middle, top + PANEL.1 + 8), 14, HPos::Center, INK)?;
    }
    Ok(())
}

/// A number with two digits.
fn short(value: f64) -> String {
    if value >= 1e-3 {
        let digits = (1 - value.log10().floor() as i32).max(0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.1e}")
    }
}

fn fill(verdict: Verdict) -> style::Color {
    match verdict {
        Verdict::Accurate => BLUE,
        Verdict::Usable => SKY_BLUE,
        Verdict::Warned => ORANGE,
        Verdict::Wrong => VERMILLION,
        Verdict::Failed => YELLOW,
        Verdict::TooSlow => (200, 200, 200),
        Verdict::NotApplicable => (255, 255, 255),
    }
}

/// A cell with its mark: a cross where wrong, an upright where warned of, a bar where failed, dots where too slow, a thin stroke where not
/// applicable.
fn swatch<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    [(left, top), (right, bottom)]: [(i32, i32); 2],
    verdict: Verdict,
) -> Drawn<DB> {
    let (red, green, blue) = fill(verdict);
    area.draw(&Rectangle::new([(left, top), (right, bottom)], RGBColor(red, green, blue).filled()))?;
    let (x, y) = ((left + right) / 2, (top + bottom) / 2);
    let arm = ((right - left).min(bottom - top) / 4).clamp(1, 6);
    let line = |from: (i32, i32), to: (i32, i32), color: RGBColor, width: u32| {
        PathElement::new(vec![(x + from.0, y + from.1), (x + to.0, y + to.1)], color.stroke_width(width))
    };
    match verdict {
        Verdict::Accurate | Verdict::Usable => {}
        Verdict::Wrong => {
            area.draw(&line((-arm, -arm), (arm, arm), BLACK, 2))?;
            area.draw(&line((-arm, arm), (arm, -arm), BLACK, 2))?;
        }
        Verdict::Warned => area.draw(&line((0, -arm), (0, arm), BLACK, 2))?,
        Verdict::Failed => area.draw(&line((-arm, 0), (arm, 0), BLACK, 2))?,
        Verdict::TooSlow => area.draw(&Circle::new((x, y), (arm / 3).max(1), BLACK.filled()))?,
        Verdict::NotApplicable => area.draw(&line((-arm, arm), (arm, -arm), RGBColor(200, 200, 200), 1))?,
    }
    // Between narrow cells a grid would be all that is seen.
    if right - left >= NARROW {
        return area.draw(&Rectangle::new([(left, top), (right, bottom)], WHITE.stroke_width(1)));
    }
    [top, bottom].into_iter().try_for_each(|y| area.draw(&PathElement::new(vec![(left, y), (right, y)], WHITE)))
}

fn legend<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, top: i32) -> Drawn<DB> {
    let mut left = 24;
    for verdict in Verdict::ALL {
        let words = verdict.legend();
        swatch(area, [(left, top), (left + 26, top + 18)], verdict)?;
        area.draw(&Rectangle::new([(left, top), (left + 26, top + 18)], QUIET.stroke_width(1)))?;
        text(area, words, (left + 34, top), 17, HPos::Left, INK)?;
        left += 34 + words.chars().count() as i32 * 8 + 18;
    }
    Ok(())
}

//! The sheet that every picture is drawn on: the same for SVG and PNG, with a font of its own.

use crate::error::ChartError;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, register_font};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::OnceLock;

/// Lines and letters.
pub const INK: RGBColor = RGBColor(30, 30, 30);
/// The colour of secondary text.
pub const QUIET: RGBColor = RGBColor(90, 90, 90);

/// DejaVu Sans, under the licence beside it. Without a font of our own a PNG would depend on the installed fonts.
static FONT: &[u8] = include_bytes!("font/DejaVuSans.ttf");

/// The result of drawing.
pub type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// A picture of a size in pixels as the text of an SVG file; `title` names it in errors.
///
/// # Errors
/// [`ChartError::Draw`] if the drawing library fails.
pub fn svg_of<'t>(
    title: &str,
    size: (i32, i32),
    draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Drawn<SVGBackend<'t>>,
) -> Result<String, ChartError> {
    prepare(title)?;
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, unsigned(size)).into_drawing_area();
        draw(&area).and_then(|()| area.present()).map_err(|error| failed(title, &error))?;
    }
    Ok(text)
}

/// A picture of a size in pixels as a PNG file; `title` names it in errors.
///
/// # Errors
/// [`ChartError::Draw`] if the drawing library fails or the file cannot be written.
pub fn png_of<'p>(
    title: &str,
    size: (i32, i32),
    path: &Path,
    draw: impl FnOnce(&DrawingArea<BitMapBackend<'_>, Shift>) -> Drawn<BitMapBackend<'p>>,
) -> Result<(), ChartError> {
    prepare(title)?;
    let (width, height) = unsigned(size);
    // Red, green and blue of every pixel, row by row.
    let mut pixels = vec![0; 3 * width as usize * height as usize];
    {
        let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
        draw(&area).and_then(|()| area.present()).map_err(|error| failed(title, &error))?;
    }
    write_png(path, (width, height), &pixels).map_err(|error| failed(title, &error))
}

fn write_png(path: &Path, (width, height): (u32, u32), pixels: &[u8]) -> Result<(), png::EncodingError> {
    let mut file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    // A full disk shows here at the latest.
    Ok(file.flush()?)
}

fn unsigned((width, height): (i32, i32)) -> (u32, u32) {
    (width.unsigned_abs(), height.unsigned_abs())
}

fn failed(title: &str, reason: &dyn std::fmt::Display) -> ChartError {
    ChartError::Draw { what: title.to_string(), reason: reason.to_string() }
}

/// Makes the font known, once.
fn prepare(title: &str) -> Result<(), ChartError> {
    static KNOWN: OnceLock<bool> = OnceLock::new();
    let known = *KNOWN.get_or_init(|| register_font("sans-serif", FontStyle::Normal, FONT).is_ok());
    if known { Ok(()) } else { Err(failed(title, &"the built-in font cannot be read")) }
}

/// Words whose upper edge is at `place`.
pub fn text<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    words: &str,
    place: (i32, i32),
    size: i32,
    anchor: HPos,
    ink: RGBColor,
) -> Drawn<DB> {
    let style = ("sans-serif", size).into_font().color(&ink).pos(Pos::new(anchor, VPos::Top));
    area.draw(&Text::new(words.to_string(), place, style))
}

/// Words in ink at `place`, turned to read upwards if `upright`.
pub fn text_at<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    words: &str,
    place: (i32, i32),
    size: i32,
    (horizontal, vertical): (HPos, VPos),
    upright: bool,
) -> Drawn<DB> {
    let font = ("sans-serif", size).into_font();
    let font = if upright { font.transform(FontTransform::Rotate270) } else { font };
    let style = font.color(&INK).pos(Pos::new(horizontal, vertical));
    area.draw(&Text::new(words.to_string(), place, style))
}

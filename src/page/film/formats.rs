//! Files of films: GIF, MP4 by `ffmpeg`, and PNG.
//!
//! ```text
//!     gif   palette.rs chooses 255 colours from at most twelve pictures; of each picture the part that changes is written
//!     mp4   raw pictures go to `ffmpeg` through a pipe; it chooses its encoder for MP4
//!     png   one picture, or several side by side
//! ```

use crate::film::canvas::Image;
use crate::film::error::FilmError;
use crate::film::palette::{Histogram, TRANSPARENT};
use gif::{DisposalMethod, Encoder, Repeat};
use std::borrow::Cow;
use std::ffi::OsStr;
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

/// The most pictures that the colours of a GIF are chosen from.
const CHOSEN_FROM: usize = 12;

/// The longest side of a GIF (pixels).
pub(super) const WIDEST_GIF: usize = u16::MAX as usize;

/// The kind of file that its ending names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A film that browsers and documents show.
    Gif,
    /// A film by `ffmpeg`.
    Mp4,
    /// A picture.
    Png,
}

impl Format {
    /// The format of a file with this name.
    ///
    /// # Errors
    /// [`FilmError::Ending`].
    pub fn of(path: &Path) -> Result<Self, FilmError> {
        let ending = path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        match ending.as_deref() {
            Some("gif") => Ok(Format::Gif),
            Some("mp4") => Ok(Format::Mp4),
            Some("png") => Ok(Format::Png),
            _ => Err(FilmError::Ending { file: path.into() }),
        }
    }

    /// The size of pictures unless the user wants another (pixels). A GIF, which is compressed less well, has smaller ones.
    pub fn usual_size(self) -> [usize; 2] {
        match self {
            Format::Gif => [640, 360],
            Format::Mp4 | Format::Png => [960, 540],
        }
    }
}

/// Draws the picture of an instant (s).
pub(super) type Draw<'d> = dyn FnMut(f64, &mut Image) -> Result<(), FilmError> + 'd;

/// Pictures at instants, as many a second of the film.
pub(super) struct Film<'f> {
    /// Times in the run (s).
    pub instants: &'f [f64],
    /// Pictures a second.
    pub rate: f64,
    /// Width and height (pixels).
    pub size: [usize; 2],
}

impl Film<'_> {
    /// Writes the film as a file of this format.
    pub(super) fn write(&self, format: Format, file: &Path, draw: &mut Draw) -> Result<(), FilmError> {
        match format {
            Format::Gif => self.write_gif(file, draw),
            Format::Mp4 => self.write_mp4(file, draw),
            Format::Png => self.write_png(file, draw),
        }
    }

    fn write_gif(&self, file: &Path, draw: &mut Draw) -> Result<(), FilmError> {
        let cannot = |error: gif::EncodingError| FilmError::write(file, std::io::Error::other(error));
        let mut image = Image::default();
        let mut histogram = Histogram::new();
        let stride = self.instants.len().div_ceil(CHOSEN_FROM).max(1);
        for time in self.instants.iter().step_by(stride) {
            draw(*time, &mut image)?;
            histogram.add(&image);
        }
        let mut palette = histogram.palette();
        // The screen of a GIF counts in 16 bits, which `FilmOptions` was checked for.
        let [width, height] = self.size.map(|pixels| pixels as u16);
        let mut colors: Vec<u8> = palette.colors.concat();
        colors.resize(3 * (usize::from(TRANSPARENT) + 1), 0);
        let output = BufWriter::new(File::create(file).map_err(|reason| FilmError::write(file, reason))?);
        let mut encoder = Encoder::new(output, width, height, &colors).map_err(cannot)?;
        encoder.set_repeat(Repeat::Infinite).map_err(cannot)?;
        let mut shown: Vec<u8> = Vec::new();
        for (number, time) in self.instants.iter().enumerate() {
            draw(*time, &mut image)?;
            let indices: Vec<u8> = image.pixels.iter().map(|pixel| palette.index(*pixel)).collect();
            let mut frame = changed(&shown, &indices, self.size[0]);
            frame.delay = (self.hundredths(number + 1) - self.hundredths(number)) as u16;
            encoder.write_frame(&frame).map_err(cannot)?;
            shown = indices;
        }
        let mut output = encoder.into_inner().map_err(cannot)?;
        output.flush().map_err(|reason| FilmError::write(file, reason))
    }

    /// The end of the first so many pictures, in the hundredths of a second in which a GIF counts.
    fn hundredths(&self, pictures: usize) -> u64 {
        (100.0 * pictures as f64 / self.rate).round() as u64
    }

    fn write_mp4(&self, file: &Path, draw: &mut Draw) -> Result<(), FilmError> {
        let [width, height] = self.size;
        let started = Command::new("ffmpeg")
            .args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"])
            .args(["-s", &format!("{width}x{height}"), "-r", &self.rate.to_string(), "-i", "-"])
            .args(["-pix_fmt", "yuv420p", "-movflags", "+faststart"])
            .arg(file)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        let mut ffmpeg = started.map_err(|error| match error.kind() {
            ErrorKind::NotFound => FilmError::NoEncoder,
            _ => FilmError::Encoder { said: error.to_string() },
        })?;
        let mut input = ffmpeg.stdin.take();
        let mut image = Image::default();
        let mut drawn = Ok(());
        for time in self.instants {
            drawn = draw(*time, &mut image);
            let taken = input.as_mut().is_some_and(|pipe| pipe.write_all(image.pixels.as_flattened()).is_ok());
            // An encoder that takes no more says why when it ends.
            if drawn.is_err() || !taken {
                break;
            }
        }
        drop(input);
        let mut said = String::new();
        if let Some(mut errors) = ffmpeg.stderr.take() {
            // Words that cannot be read are lost; that it failed is known from its exit code.
            let _ = errors.read_to_string(&mut said);
        }
        let ended = ffmpeg.wait();
        drawn?;
        match ended {
            Ok(code) if code.success() => Ok(()),
            Ok(code) => Err(FilmError::Encoder { said: if said.trim().is_empty() { code.to_string() } else { said } }),
            Err(error) => Err(FilmError::Encoder { said: error.to_string() }),
        }
    }

    fn write_png(&self, file: &Path, draw: &mut Draw) -> Result<(), FilmError> {
        let [width, height] = self.size;
        let whole = width * self.instants.len();
        let mut pixels = vec![[0u8; 3]; whole * height];
        let mut image = Image::default();
        for (number, time) in self.instants.iter().enumerate() {
            draw(*time, &mut image)?;
            for (row, from) in image.pixels.chunks_exact(width).enumerate() {
                pixels[row * whole + number * width..][..width].copy_from_slice(from);
            }
        }
        let output = BufWriter::new(File::create(file).map_err(|reason| FilmError::write(file, reason))?);
        let mut encoder = png::Encoder::new(output, whole as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(pixels.as_flattened())?;
            writer.finish()
        });
        written.map_err(|error| FilmError::write(file, std::io::Error::other(error)))
    }
}

/// The smallest rectangle of a picture that has all changes, in which pixels that stay are transparent; one pixel if none changes.
fn changed<'p>(before: &[u8], now: &'p [u8], width: usize) -> gif::Frame<'p> {
    let [full_width, full_height] = [width, now.len() / width].map(|pixels| pixels as u16);
    let whole =
        gif::Frame { width: full_width, height: full_height, dispose: DisposalMethod::Keep, ..gif::Frame::default() };
    if before.is_empty() {
        return gif::Frame { buffer: Cow::Borrowed(now), ..whole };
    }
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for (pixel, _) in now.iter().zip(before).enumerate().filter(|(_, (now, before))| now != before) {
        let place = [pixel % width, pixel / width];
        for axis in 0..2 {
            low[axis] = low[axis].min(place[axis]);
            high[axis] = high[axis].max(place[axis]);
        }
    }
    if low[0] == usize::MAX {
        (low, high) = ([0; 2], [0; 2]);
    }
    let rows = (low[1]..=high[1]).map(|row| row * width + low[0]..row * width + high[0] + 1);
    let kept = rows.flatten().map(|pixel| if now[pixel] == before[pixel] { TRANSPARENT } else { now[pixel] });
    let [left, top, width, height] =
        [low[0], low[1], high[0] + 1 - low[0], high[1] + 1 - low[1]].map(|value| value as u16);
    gif::Frame { left, top, width, height, transparent: Some(TRANSPARENT), buffer: kept.collect(), ..whole }
}

#[cfg(test)]
mod tests {
    use super::{TRANSPARENT, changed};

    #[test]
    fn a_frame_has_the_rectangle_that_changes() {
        let before = [0u8; 12];
        let mut now = before;
        (now[5], now[10]) = (7, 8);
        let frame = changed(&before, &now, 4);
        assert_eq!([frame.left, frame.top, frame.width, frame.height], [1, 1, 2, 2]);
        assert_eq!(frame.buffer[..], [7, TRANSPARENT, TRANSPARENT, 8]);
        assert_eq!(changed(&before, &before, 4).buffer[..], [TRANSPARENT], "a picture without changes is one pixel");
    }
}

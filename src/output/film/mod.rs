//! Films: the run of a log as GIF, MP4 or PNG.
//!
//! ```text
//!     log ─ page/motion.rs ─▶ poses at the samples
//!     model ─ page/looks.rs, page/colliders.rs ─▶ parts.rs (primitives.rs, normals.rs)      triangles of each body
//!     both ─▶ scene.rs (camera.rs, background.rs) ─▶ canvas.rs ─▶ formats.rs (palette.rs) ─▶ file
//!     t_k = t_0 + k · speed / rate        the instant of the picture k (s)
//! ```
//!
//! The renderer is the program's own: it needs no browser and no graphics card, and the same log and build give the same bytes. A browser may draw the
//! pictures instead, from the page of the run (browser.rs): with arrows of forces, and some ten times slower.

mod background;
mod browser;
mod camera;
mod canvas;
mod formats;
mod normals;
mod palette;
mod parts;
mod primitives;
mod scene;

pub use camera::View;
pub use formats::Format;

use crate::drawing::error::ChartError;
use crate::drawing::files::write_with;
use crate::model::Model;
use crate::output::film::browser::Browser;
use crate::output::film::canvas::Image;
use crate::output::film::formats::{Film, WIDEST_GIF};
use crate::output::film::parts::Parts;
use crate::output::film::scene::Scene;
use crate::output::inspection::summary::Summary;
use crate::output::log::reading::meshes::LoggedMeshes;
use crate::output::page::{MESH_LIMIT, PageError, logged_mesh, motion_of};
use crate::scene::MeshFile;
use std::path::{Path, PathBuf};

/// Fewest and most pixels of a side. A canvas of 4096 × 4096 needs half a gigabyte.
pub const SIDES: std::ops::RangeInclusive<usize> = 16..=4096;

/// Fewest and most pictures a second: GIF counts in hundredths of a second, in 16 bits.
pub const RATES: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// The options of a film.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmOptions {
    /// Width and height (pixels).
    pub size: [usize; 2],
    /// Pictures in a second of the film.
    pub rate: f64,
    /// Seconds of the run in a second of the film.
    pub speed: f64,
    /// The side from which it is seen.
    pub view: View,
    /// Times (s): of a film the first and the last, of a PNG those of the pictures. Empty: the whole run, or its last sample.
    pub times: Vec<f64>,
    /// The most triangles of all meshes together.
    pub mesh_limit: usize,
}

impl Default for FilmOptions {
    /// 960 × 540, 25 pictures a second at the speed of the run.
    fn default() -> Self {
        let (size, view) = (Format::Mp4.usual_size(), View::default());
        FilmOptions { size, rate: 25.0, speed: 1.0, view, times: Vec::new(), mesh_limit: MESH_LIMIT }
    }
}

/// The film that was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Filmed {
    /// Number of pictures.
    pub pictures: usize,
    /// The instants of the first and of the last (s).
    pub span: [f64; 2],
    /// Shapes that are not drawn, or not as in their files.
    pub notes: Vec<String>,
}

/// Why there is no film.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// The log has no motion to show.
    #[error(transparent)]
    Page(#[from] PageError),
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] ChartError),
    /// The name of the file says no known format.
    #[error("cannot write {}: its ending is none of .gif, .mp4, .png", file.display())]
    Ending {
        /// The file.
        file: PathBuf,
    },
    /// A number that no film can have.
    #[error("{option} {given}: {reason}")]
    Option {
        /// The option, as on the command line.
        option: &'static str,
        /// The value.
        given: String,
        /// The defect and the remedy.
        reason: String,
    },
    /// There is no `ffmpeg`.
    #[error(
        "MP4 needs ffmpeg, which is not on the PATH: install it (Debian: apt-get install ffmpeg; macOS: brew install ffmpeg; Windows: winget \
         install ffmpeg), or write a .gif, which needs no other program"
    )]
    NoEncoder,
    /// The browser failed.
    #[error("the browser: {reason}")]
    Browser {
        /// The defect.
        reason: String,
    },
    /// `ffmpeg` failed.
    #[error("ffmpeg could not write the film: {said}")]
    Encoder {
        /// Its words.
        said: String,
    },
}

impl FilmError {
    fn write(file: &Path, reason: std::io::Error) -> Self {
        FilmError::Write(ChartError::Write { path: file.into(), reason })
    }

    fn option(option: &'static str, given: impl std::fmt::Display, reason: impl Into<String>) -> Self {
        FilmError::Option { option, given: given.to_string(), reason: reason.into() }
    }
}

impl FilmOptions {
    /// Whether a film of this format can have these options.
    ///
    /// # Errors
    /// [`FilmError::Option`].
    pub fn check(&self, format: Format) -> Result<(), FilmError> {
        let [width, height] = self.size;
        let size = || format!("{width}x{height}");
        if !self.size.iter().all(|side| SIDES.contains(side)) {
            let reason = format!("both sides must have {} to {} pixels", SIDES.start(), SIDES.end());
            return Err(FilmError::option("--size", size(), reason));
        }
        if format == Format::Mp4 && self.size.iter().any(|side| side % 2 == 1) {
            return Err(FilmError::option("--size", size(), "MP4 halves the resolution of colours: give even numbers"));
        }
        let pictures = if format == Format::Png { self.times.len().max(1) } else { 1 };
        if width * pictures > WIDEST_GIF {
            let reason =
                format!("{pictures} pictures side by side are wider than {WIDEST_GIF} pixels: give a smaller --size");
            return Err(FilmError::option("--size", size(), reason));
        }
        if !RATES.contains(&self.rate) {
            let reason = format!("it must be from {} to {}", RATES.start(), RATES.end());
            return Err(FilmError::option("--fps", self.rate, reason));
        }
        if !(self.speed > 0.0 && self.speed.is_finite()) {
            return Err(FilmError::option("--speed", self.speed, "it must be above 0"));
        }
        if let Some(time) = self.times.iter().find(|time| !time.is_finite()) {
            return Err(FilmError::option("--time", time, "times are finite numbers of seconds"));
        }
        if format != Format::Png && self.times.len() > 2 {
            let given = self.times.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
            return Err(FilmError::option(
                "--time",
                given,
                "a film has a first and a last instant; a .png may have more",
            ));
        }
        Ok(())
    }

    /// The instants of the pictures (s), for a run with samples from `first` to `last`.
    fn instants(&self, format: Format, [first, last]: [f64; 2]) -> Result<Vec<f64>, FilmError> {
        if let Some(time) = self.times.iter().find(|time| **time < first || **time > last) {
            let reason = format!("the log has samples from {first} to {last} s");
            return Err(FilmError::option("--time", time, reason));
        }
        if format == Format::Png {
            return Ok(if self.times.is_empty() { vec![last] } else { self.times.clone() });
        }
        let from = self.times.first().copied().unwrap_or(first);
        let to = self.times.get(1).copied().unwrap_or(last);
        if to < from {
            return Err(FilmError::option("--time", format!("{from},{to}"), "the film ends before it begins"));
        }
        let step = self.speed / self.rate;
        // A last picture that is late by roundings is shown, too.
        let count = ((to - from) / step + 1e-6).floor() as usize;
        Ok((0..=count).map(|k| (from + k as f64 * step).min(to)).collect())
    }
}

/// Writes the film of a log, whose model is the one that the log carries. With a `page` of the run a browser draws its pictures. `drawn` is told the
/// number of pictures that were drawn, and of all.
///
/// # Errors
/// [`FilmError`]; an older film is then as it was.
pub fn write_film(
    log: &Path,
    model: &Model,
    page: Option<&str>,
    file: &Path,
    options: &FilmOptions,
    drawn: &mut dyn FnMut(usize, usize),
) -> Result<Filmed, FilmError> {
    let format = Format::of(file)?;
    options.check(format)?;
    let summary = Summary::read(log).map_err(PageError::from)?;
    let motion = motion_of(log, model, &summary)?;
    let instants = options.instants(format, [motion.times[0], motion.times[motion.times.len() - 1]])?;
    let film = Film { instants: &instants, rate: options.rate, size: options.size };
    let mut count = 0;
    let mut counted = || {
        count += 1;
        drawn(count.min(instants.len()), instants.len());
    };
    let notes = if let Some(page) = page {
        let mut browser = Browser::open(page, options.view, options.size)?;
        let mut draw = |time: f64, image: &mut Image| browser.draw(time, image).map(|()| counted());
        write_with(file, |part| film.write(format, part, &mut draw))?;
        Vec::new()
    } else {
        let logged = LoggedMeshes::read(log).map_err(PageError::from)?;
        let source = |link: &str, number: usize, _: &MeshFile| logged_mesh(&logged, link, number);
        let parts = Parts::of(model, &source, options.mesh_limit);
        let notes = parts.notes.clone();
        let mut scene = Scene::new(motion, parts, options);
        let mut draw = |time: f64, image: &mut Image| {
            scene.draw(time, image);
            counted();
            Ok(())
        };
        write_with(file, |part| film.write(format, part, &mut draw))?;
        notes
    };
    Ok(Filmed { pictures: instants.len(), span: [instants[0], instants[instants.len() - 1]], notes })
}

#[cfg(test)]
mod tests {
    use super::{FilmOptions, Format};

    #[test]
    fn instants_follow_each_other_by_the_speed_over_the_rate() {
        let slow = FilmOptions { rate: 20.0, speed: 0.5, ..FilmOptions::default() };
        let instants = slow.instants(Format::Gif, [0.0, 1.0]).expect("instants");
        // 2 s of film at 20 pictures a second, and the last instant.
        assert_eq!((instants.len(), instants[1], instants[40]), (41, 0.025, 1.0));
        let part = FilmOptions { times: vec![0.25, 0.5], ..slow.clone() };
        assert_eq!(part.instants(Format::Mp4, [0.0, 1.0]).expect("instants").len(), 11);
        assert_eq!(slow.instants(Format::Png, [0.0, 1.0]).expect("instants"), [1.0]);
        let outside = FilmOptions { times: vec![1.5], ..slow };
        let refused = outside.instants(Format::Png, [0.0, 1.0]).expect_err("outside").to_string();
        assert_eq!(refused, "--time 1.5: the log has samples from 0 to 1 s");
    }

    #[test]
    fn numbers_that_no_film_can_have_are_refused() {
        let usual = FilmOptions::default;
        let cases = [
            (FilmOptions { size: [8, 540], ..usual() }, Format::Gif, "--size 8x540"),
            (FilmOptions { size: [961, 540], ..usual() }, Format::Mp4, "even numbers"),
            (FilmOptions { rate: 0.0, ..usual() }, Format::Gif, "--fps 0"),
            (FilmOptions { rate: f64::NAN, ..usual() }, Format::Gif, "--fps NaN"),
            (FilmOptions { speed: -1.0, ..usual() }, Format::Gif, "--speed -1"),
            (FilmOptions { times: vec![0.0, 1.0, 2.0], ..usual() }, Format::Gif, "--time 0,1,2"),
            (FilmOptions { times: vec![0.0; 100], ..usual() }, Format::Png, "smaller --size"),
        ];
        for (options, format, words) in cases {
            let refused = options.check(format).expect_err(words).to_string();
            assert!(refused.contains(words), "{refused}");
        }
        assert!(usual().check(Format::Mp4).is_ok());
    }
}

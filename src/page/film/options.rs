//! The options of a film, and the instants of its pictures.
//!
//! ```text
//!     t_k = t_0 + k · speed / rate        the instant of the picture k (s)
//! ```

use crate::film::camera::View;
use crate::film::error::FilmError;
use crate::film::formats::{Format, WIDEST_GIF};
use crate::page::MESH_LIMIT;

/// Fewest and most pixels of a side. A canvas of 4096 × 4096 needs half a gigabyte.
pub const SIDES: std::ops::RangeInclusive<usize> = 16..=4096;

/// Fewest and most pictures a second: GIF counts in hundredths of a second, in 16 bits.
pub const RATES: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// The most pictures of a film: more than an hour of it.
const MOST_PICTURES: f64 = 1e5;

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
    pub(super) fn instants(&self, format: Format, [first, last]: [f64; 2]) -> Result<Vec<f64>, FilmError> {
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
        let count = ((to - from) / step + 1e-6).floor();
        if count > MOST_PICTURES {
            let reason = format!(
                "the film would have {count:.3e} pictures, more than {MOST_PICTURES:e}: give a larger one, or less of the run by --time"
            );
            return Err(FilmError::option("--speed", self.speed, reason));
        }
        let count = count as usize;
        Ok((0..=count).map(|k| (from + k as f64 * step).min(to)).collect())
    }
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
        let endless = FilmOptions { speed: 1e-9, ..FilmOptions::default() };
        let refused = endless.instants(Format::Gif, [0.0, 2.0]).expect_err("endless").to_string();
        assert!(refused.starts_with("--speed 0.000000001: the film would have 5.000e10 pictures"), "{refused}");
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

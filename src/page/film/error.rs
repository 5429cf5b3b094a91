//! The reasons for the absence of a film.

use crate::drawing::error::ChartError;
use crate::page::PageError;
use std::path::{Path, PathBuf};

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
    pub(super) fn write(file: &Path, reason: std::io::Error) -> Self {
        FilmError::Write(ChartError::Write { path: file.into(), reason })
    }

    pub(super) fn option(option: &'static str, given: impl std::fmt::Display, reason: impl Into<String>) -> Self {
        FilmError::Option { option, given: given.to_string(), reason: reason.into() }
    }
}

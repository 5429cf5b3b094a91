//! Errors of sweeps.

use crate::instant::start::assembly::AssemblyError;
use crate::model::ModelError;
use crate::scene::SceneError;
use std::io;
use std::path::PathBuf;

/// Why a sweep cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The sweep file, or a file that it names.
    #[error(transparent)]
    File(#[from] SceneError),
    /// A robot where a sweep file should be.
    #[error("{}: this is a robot, and no sweep file: write one in TOML that names it as scene of its table [sweep]", path.display())]
    NotASweep {
        /// The robot.
        path: PathBuf,
    },
    /// The scene, with the numbers of its files.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The start of the scene, with the numbers of its files.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The folder is there, and is of something else or cannot be used.
    #[error("cannot use {}: {reason}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Why, and what to do.
        reason: String,
    },
    /// A file cannot be written or read.
    #[error("cannot {what} {}: {reason}", path.display())]
    Disk {
        /// `write` or `read`.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// The reason that the system gives.
        reason: String,
    },
    /// It was asked to end.
    #[error("interrupted; {done} of {runs} runs are done: the same command goes on with the others")]
    Interrupted {
        /// Rows on the disk.
        done: u64,
        /// Runs of the sweep, or of its shard.
        runs: u64,
    },
}

impl SweepError {
    /// Whether the input is wrong, and not a later operation.
    pub fn is_input(&self) -> bool {
        !matches!(self, SweepError::Disk { .. } | SweepError::Interrupted { .. })
    }

    pub(crate) fn folder(folder: &std::path::Path, reason: impl Into<String>) -> Self {
        SweepError::Folder { folder: folder.to_path_buf(), reason: reason.into() }
    }

    pub(crate) fn write(path: &std::path::Path, error: &io::Error) -> Self {
        SweepError::Disk { what: "write", path: path.to_path_buf(), reason: error.to_string() }
    }

    pub(crate) fn read(path: &std::path::Path, error: &io::Error) -> Self {
        SweepError::Disk { what: "read", path: path.to_path_buf(), reason: error.to_string() }
    }
}

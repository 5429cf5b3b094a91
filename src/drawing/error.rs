//! Errors of charts and their files.

use std::path::PathBuf;

/// Why there is no chart.
#[derive(Debug, thiserror::Error)]
pub enum ChartError {
    /// A file could not be written.
    #[error("cannot write {}: {reason}", path.display())]
    Write { path: PathBuf, reason: std::io::Error },
    /// A file could not be read.
    #[error("cannot read {}: {reason}", path.display())]
    Read { path: PathBuf, reason: std::io::Error },
    /// A CSV file is malformed.
    #[error("{}:{line}: {problem}", path.display())]
    Csv { path: PathBuf, line: usize, problem: String },
    /// The drawing library failed.
    #[error("cannot draw {what}: {reason}")]
    Draw { what: String, reason: String },
    /// Neither formulation could run the scene accurately.
    #[error("scene {scene:?}: no reference solution; {reason}")]
    Reference { scene: String, reason: String },
    /// The user asked to stop before there was anything to show.
    #[error("interrupted while the reference solution of scene {scene:?} was computed")]
    Interrupted { scene: String },
}

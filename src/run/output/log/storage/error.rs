//! Why a log cannot be written.

use std::io;
use std::path::PathBuf;

/// Why the log could not be written.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file could not be created, and is unchanged.
    #[error("cannot create {}: {reason}", path.display())]
    Create { path: PathBuf, reason: io::Error },
    /// Another run is writing the file, which is unchanged.
    #[error("cannot write {}: another run is writing it; choose another --output", path.display())]
    Busy { path: PathBuf },
    /// The run was interrupted while it waited for a reader of the pipe or device.
    #[error("interrupted while waiting for a reader of {}", path.display())]
    Blocked { path: PathBuf },
    /// Writing failed: a full disk, a closed pipe.
    #[error("cannot write {}: {reason}", path.display())]
    Write { path: PathBuf, reason: io::Error },
}

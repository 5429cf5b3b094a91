//! Where a run may write: never over what it is made from, and only where a file can be.

#[cfg(feature = "log")]
use crate::model::Model;
#[cfg(feature = "log")]
use crate::output::log::{LONGEST, LogOptions, neighbour, seconds};
use crate::session::error::Error;
use std::path::Path;

fn refuse(path: &Path, reason: String) -> Error {
    Error::Output { path: path.to_path_buf(), reason }
}

/// Whether what is at a path is a pipe or device, which keeps what was written.
pub fn is_special(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|metadata| !metadata.is_file())
}

/// The folder that a path is in.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Whether a file can be at this place.
///
/// # Errors
/// [`Error::Output`] if there is no folder for it, or it is one.
pub fn check_place(output: &Path) -> Result<(), Error> {
    let folder = folder_of(output);
    if output.as_os_str().to_string_lossy().ends_with(std::path::is_separator) {
        return Err(refuse(output, "give a file, not a folder".to_string()));
    }
    if !folder.is_dir() {
        return Err(refuse(output, format!("there is no folder {}", folder.display())));
    }
    if output.is_dir() {
        return Err(refuse(output, "it is a folder".to_string()));
    }
    Ok(())
}

/// Whether a log of so many seconds may be at this place: neither it nor its file while the run has not finished may replace what the run is
/// made from.
///
/// # Errors
/// [`Error::Output`] if it would, [`Error::TooLong`] if it cannot count its nanoseconds.
#[cfg(feature = "log")]
pub fn check_log(output: &Path, model: &Model, duration: f64, options: &LogOptions) -> Result<(), Error> {
    let wanted = output.canonicalize().unwrap_or_else(|_| output.to_path_buf());
    for written in [neighbour(&wanted), wanted].iter().filter_map(|path| path.canonicalize().ok()) {
        if model.files().any(|file| file.canonicalize().is_ok_and(|file| file == written)) {
            return Err(refuse(output, format!("the run is made from {}; choose another --output", written.display())));
        }
    }
    if duration + seconds(options.start) > LONGEST {
        return Err(Error::TooLong { longest: LONGEST, duration });
    }
    Ok(())
}

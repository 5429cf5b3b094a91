//! Checks that a run may write its log to a path: not over its own input, and only to a possible path.

#[cfg(feature = "log")]
use crate::model::Model;
#[cfg(feature = "log")]
use crate::output::log::{LONGEST, LogOptions, neighbour, seconds};
use crate::session::error::Error;
use std::path::Path;

fn refuse(path: &Path, reason: String) -> Error {
    Error::Output { path: path.to_path_buf(), reason }
}

/// The folder of a path.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Checks that a file can be created at this path.
///
/// # Errors
/// [`Error::Output`] if its folder does not exist, or if it is a folder.
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

/// Checks that a log of this duration (s) may be written to this path. Neither the log nor its unfinished file may replace an input of the run.
///
/// # Errors
/// [`Error::Output`] if it would, [`Error::TooLong`] if its times in nanoseconds overflow.
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

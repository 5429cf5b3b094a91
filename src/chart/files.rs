//! Files that are whole or not there: written beside their place under another name, then renamed.

use super::error::ChartError;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes a text file.
///
/// # Errors
/// [`ChartError::Write`]; the old file is then as it was.
pub fn write_text(path: &Path, text: &str) -> Result<(), ChartError> {
    write_with(path, |part| fs::write(part, text).map_err(|source| ChartError::Write { path: path.into(), source }))
}

/// Writes a file with a function that is given the path to write to.
///
/// # Errors
/// Those of the function, and [`ChartError::Write`]; the old file is then as it was.
pub fn write_with(path: &Path, write: impl FnOnce(&Path) -> Result<(), ChartError>) -> Result<(), ChartError> {
    let part = part_name(path);
    let written = write(&part)
        .and_then(|()| fs::rename(&part, path).map_err(|source| ChartError::Write { path: path.into(), source }));
    if written.is_err() {
        // Whatever half of it there is; the error that is reported is the first one.
        let _ = fs::remove_file(&part);
    }
    written
}

/// The same folder and ending (the drawing library goes by it), another name.
fn part_name(path: &Path) -> PathBuf {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    path.with_file_name(format!(".part-{}-{name}", std::process::id()))
}

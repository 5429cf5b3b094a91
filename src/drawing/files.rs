//! Files that are whole or not there: written beside their place under another name, then renamed.

use crate::error::ChartError;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes a text file.
///
/// # Errors
/// [`ChartError::Write`]; the old file is then as it was.
pub fn write_text(path: &Path, text: &str) -> Result<(), ChartError> {
    write_with(path, |part| fs::write(part, text).map_err(|reason| ChartError::Write { path: path.into(), reason }))
}

/// Writes a file with a function that is given the path to write to. A link stays a link, and its target is written. What is no file, such as
/// `/dev/null` or a named pipe, is written to as it is: a file in its place would be there for every other program, too.
///
/// # Errors
/// The errors of the function, and [`ChartError::Write`]; the old file is then unchanged.
pub fn write_with<E: From<ChartError>>(path: &Path, write: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
    if fs::metadata(path).is_ok_and(|known| !known.is_file() && !known.is_dir()) {
        return write(path);
    }
    let place = behind_links(path);
    let part = part_name(&place);
    let rename = || fs::rename(&part, &place).map_err(|reason| ChartError::Write { path: path.into(), reason });
    let written = write(&part).and_then(|()| Ok(rename()?));
    if written.is_err() {
        // Whatever half of it there is; the error that is reported is the first one.
        let _ = fs::remove_file(&part);
    }
    written
}

/// The target of a path, also if it does not exist yet.
fn behind_links(path: &Path) -> PathBuf {
    let dangling = || fs::read_link(path).map(|to| path.parent().map_or(to.clone(), |folder| folder.join(&to)));
    path.canonicalize().or_else(|_| dangling()).unwrap_or_else(|_| path.to_path_buf())
}

/// The same folder and ending (the drawing library goes by it), another name.
fn part_name(path: &Path) -> PathBuf {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    path.with_file_name(format!(".part-{}-{name}", std::process::id()))
}

//! Files that are whole or not there: written beside their place under another name, then renamed.

use crate::error::ChartError;
use std::fs;
use std::path::{Path, PathBuf};

/// Most links that point to each other before they are taken for a circle.
const LINKS: usize = 40;

/// Writes a text file.
///
/// # Errors
/// [`ChartError::Write`]; the old file is then as it was.
pub fn write_text(path: &Path, text: &str) -> Result<(), ChartError> {
    write_with(path, |part| fs::write(part, text).map_err(|reason| ChartError::Write { path: path.into(), reason }))
}

/// Writes a file with a function that is given the path to write to. A link stays a link, and its target is written. A pipe or device is written
/// directly: a file in its place would be there for every other program, too.
///
/// # Errors
/// The errors of the function, and [`ChartError::Write`]; the old file is then unchanged.
pub fn write_with<E: From<ChartError>>(path: &Path, write: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
    if is_special(path) {
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

/// The target of a path, also if it does not exist yet: a link is followed as far as links go.
pub fn behind_links(path: &Path) -> PathBuf {
    let mut place = path.to_path_buf();
    for _ in 0..LINKS {
        if let Ok(real) = place.canonicalize() {
            return real;
        }
        // A link of the system to something without a name, such as an open pipe.
        if place.metadata().is_ok() {
            return place;
        }
        match fs::read_link(&place) {
            Ok(to) => place = place.parent().map_or(to.clone(), |folder| folder.join(&to)),
            Err(_) => break,
        }
    }
    place
}

/// Whether a path is a pipe or device, to which bytes are written for good.
pub fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file())
}

/// The same folder and ending (the drawing library goes by it), another name.
fn part_name(path: &Path) -> PathBuf {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    path.with_file_name(format!(".part-{}-{name}", std::process::id()))
}

//! The file of a page: its path is checked first, and it is written whole or not at all.

use crate::cli::terminal::printing::Failure;
use anyhow::bail;
use catena::drawing::files::write_text;
use catena::session::{check_place, folder_of};
use std::path::Path;

/// Whether a page can be at this place. It must not replace any of these files.
///
/// # Errors
/// If it cannot.
pub fn check_page<'f>(page: &Path, mut files: impl Iterator<Item = &'f Path>) -> anyhow::Result<()> {
    check_place(page)?;
    if let Some(file) = files.find(|file| is_same(file, page)) {
        bail!("cannot write {}: the model is made from {}", page.display(), file.display());
    }
    Ok(())
}

/// Whether two paths are the same file, which may not be there yet.
pub fn is_same(one: &Path, other: &Path) -> bool {
    let place = |path: &Path| {
        path.canonicalize().or_else(|_| Ok(folder_of(path).canonicalize()?.join(path.file_name().unwrap_or_default())))
    };
    let places: [std::io::Result<_>; 2] = [place(one), place(other)];
    matches!(places, [Ok(one), Ok(other)] if one == other)
}

/// Writes a page that is not there before all of it is.
///
/// # Errors
/// [`Failure`] 1 if it cannot be written.
pub fn write_page(page: &Path, text: &str) -> Result<(), Failure> {
    write_text(page, text).map_err(Failure::run)
}

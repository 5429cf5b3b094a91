//! Files that are either complete or absent.
//!
//! A file is written beside its place, put on the disk, and then renamed: under its name it is always whole.

use crate::sweep::error::SweepError;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes a file whole or not at all.
pub(super) fn whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), SweepError> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let beside = Path::new(&beside);
    let written = || -> io::Result<()> {
        let file = File::create(beside)?;
        let mut buffer = BufWriter::with_capacity(1 << 18, &file);
        write(&mut buffer)?;
        buffer.flush()?;
        drop(buffer);
        file.sync_all()?;
        std::fs::rename(beside, path)?;
        sync_folder(path)
    };
    written().map_err(|error| {
        // The rest of the file is of no use; if it cannot be removed, the next write replaces it.
        let _ = std::fs::remove_file(beside);
        SweepError::write(path, &error)
    })
}

/// Puts the names in the folder of a file on the disk.
#[cfg(unix)]
pub(super) fn sync_folder(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
pub(super) fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

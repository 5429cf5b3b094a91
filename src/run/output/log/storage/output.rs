//! The place of a log on disk while it is written: a run that fails never destroys the result of a finished run.
//!
//! A run writes to a neighbour of its output, `NAME.unfinished.mcap`, which becomes the output by renaming:
//!
//! | what is at the output           | when the neighbour becomes the output                 | run fails or is killed |
//! |---------------------------------|-------------------------------------------------------|------------------------|
//! | nothing                         | when all that is known before the first step is in it | the output is what there is of the run |
//! | a log of catena without an end, or that says it did not finish | the same               | the same               |
//! | anything else: a finished log, another file | when the run has finished                 | the output stays, the run's log is the neighbour |
//! | a pipe or device                | it is written directly; samples at the end of the run if that may begin again | |
//!
//! A file that is being written is locked, so that a second run does not write into it and readers know that there
//! will be more.

use crate::drawing::files::{behind_links, is_special};
use crate::output::log::reading::reader::is_unfinished;
use crate::output::log::storage::error::LogError;
use std::ffi::OsString;
use std::fs::{File, Metadata, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The place of a log that is being written.
pub(crate) struct Output {
    /// The place that the user wants.
    wanted: PathBuf,
    /// The present place.
    current: PathBuf,
    /// Whether the file at the wanted place must stay until the run has finished.
    protects: bool,
}

impl Output {
    /// Makes an empty file for a log that shall be at `path`, and locks it; also says whether it is a regular file.
    ///
    /// # Errors
    /// [`LogError::Create`] if there can be no such file, [`LogError::Busy`] if another run is writing it.
    pub(crate) fn create(path: &Path) -> Result<(Self, File, bool), LogError> {
        for _ in 0..5 {
            if let Some(created) = Output::try_create(path)? {
                return Ok(created);
            }
        }
        Err(LogError::Busy { path: path.to_path_buf() })
    }

    /// The same; `None` if another run has moved its log to the output meanwhile, so that all has to be looked at again.
    fn try_create(path: &Path) -> Result<Option<(Self, File, bool)>, LogError> {
        let refuse = |path: &Path, reason| LogError::Create { path: path.to_path_buf(), reason };
        // A link stays a link, and its target is replaced.
        let wanted = behind_links(path);
        if is_special(&wanted) {
            let file = OpenOptions::new().write(true).open(&wanted).map_err(|reason| refuse(path, reason))?;
            let output = Output { current: wanted.clone(), wanted, protects: false };
            return Ok(Some((output, file, false)));
        }
        if is_locked(&wanted) {
            return Err(LogError::Busy { path: path.to_path_buf() });
        }
        let current = neighbour(&wanted);
        if current.is_symlink() {
            let reason = io::Error::other("it is a link, behind which something else would be overwritten; remove it");
            return Err(refuse(&current, reason));
        }
        let open = OpenOptions::new().write(true).create(true).truncate(false).open(&current);
        let file = open.map_err(|reason| refuse(&current, reason))?;
        if !lock(&file) {
            return Err(LogError::Busy { path: current });
        }
        // A run that has ended before the lock was ours may have made this very file the output; one that goes on writes there.
        if !is_at(&file, &current) || is_locked(&wanted) {
            return Ok(None);
        }
        // An empty file is not cut: ext4 would then write the whole log out while it is closed, as if it replaced another.
        if file.metadata().map_or(true, |metadata| metadata.len() > 0) {
            file.set_len(0).map_err(|reason| refuse(&current, reason))?;
        }
        let is_empty = std::fs::metadata(&wanted).map_or(true, |metadata| metadata.len() == 0);
        let protects = !is_empty && !is_unfinished(&wanted);
        Ok(Some((Output { wanted, current, protects }, file, true)))
    }

    /// Whether something is at the wanted place that only a finished run may replace.
    pub(crate) fn protects(&self) -> bool {
        self.protects
    }

    /// Moves the file to its place, if that may be.
    pub(crate) fn settle(&mut self, finished: bool) -> io::Result<()> {
        if self.current != self.wanted && (finished || !self.protects) {
            std::fs::rename(&self.current, &self.wanted)?;
            self.current.clone_from(&self.wanted);
        }
        Ok(())
    }

    /// The present place of the file.
    pub(crate) fn current(&self) -> &Path {
        &self.current
    }
}

/// The log of a run that has not finished, when something that must stay has its name.
pub fn neighbour(path: &Path) -> PathBuf {
    let mut name = path.file_stem().map_or_else(OsString::new, OsString::from);
    name.push(".unfinished");
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Locks a file; `false` if a run is writing it. On file systems without locks there is no protection.
fn lock(file: &File) -> bool {
    // Those who only ask whether a file is locked hold it for an instant.
    for _ in 0..5 {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(10)),
            _ => return true,
        }
    }
    false
}

/// Whether the open file still has this name.
fn is_at(file: &File, path: &Path) -> bool {
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(open), Ok(named)) => identity(&open) == identity(&named),
        _ => false,
    }
}

#[cfg(unix)]
fn identity(metadata: &Metadata) -> impl PartialEq {
    use std::os::unix::fs::MetadataExt;
    (metadata.dev(), metadata.ino())
}

/// The identity of a file without a writer, as far as the standard library tells: the time of its last write, and its length.
#[cfg(not(unix))]
fn identity(metadata: &Metadata) -> impl PartialEq {
    (metadata.modified().ok(), metadata.len())
}

/// Whether a run is writing this file; `false` on file systems without locks.
pub fn is_locked(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first run ends while the second, which has opened the file, still waits for its lock.
    #[test]
    fn a_log_that_becomes_the_output_while_another_run_waits_for_it_stays_as_it_is() {
        let folder = std::env::temp_dir().join(format!("catena-output-{}", std::process::id()));
        let (wanted, beside) = (folder.join("log.mcap"), folder.join("log.unfinished.mcap"));
        let mut started = 0;
        for _ in 0..5 {
            std::fs::create_dir_all(&folder).expect("a folder for the test");
            std::fs::write(&beside, b"the log of the first run").expect("written");
            let first = OpenOptions::new().write(true).open(&beside).expect("the file of the first run");
            first.lock().expect("locked");
            let second = std::thread::spawn({
                let wanted = wanted.clone();
                move || Output::create(&wanted)
            });
            std::thread::sleep(Duration::from_millis(15));
            std::fs::rename(&beside, &wanted).expect("the first run ends");
            drop(first);
            match second.join().expect("no panic") {
                Ok((output, file, _)) => {
                    assert!(output.protects(), "the log of the first run must stay");
                    assert_eq!((output.current(), is_at(&file, &beside)), (&*beside, true));
                    started += 1;
                }
                // A slow machine may have let the second run give up before.
                Err(error) => assert!(matches!(error, LogError::Busy { .. }), "{error}"),
            }
            assert_eq!(std::fs::read(&wanted).expect("a log"), b"the log of the first run");
            std::fs::remove_dir_all(&folder).expect("removed");
        }
        assert!(started > 0);
    }
}

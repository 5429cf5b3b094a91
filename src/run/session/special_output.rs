//! An output that is a pipe or a device. Opening it may block until a reader opens it; an interruption ends the wait.
//!
//! The file is opened on a thread of its own, while this one looks whether the run is interrupted. Whoever holds it has a reader, so that the log can
//! open it again without waiting.

use crate::drawing::files::is_special;
use crate::output::log::LogError;
use crate::session::error::Error;
use std::fs::{File, OpenOptions};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often it is asked whether the run is interrupted.
const INTERVAL: Duration = Duration::from_millis(50);

/// Opens a pipe or device at a path. `None` for a file, for a missing path, and for one that cannot be opened, which the log will report.
///
/// # Errors
/// [`Error::Unread`] if the run is interrupted before a reader opens it.
pub fn open_special(path: &Path, interrupted: &AtomicBool) -> Result<Option<File>, Error> {
    if !is_special(path) {
        return Ok(None);
    }
    let (opened, wait) = channel();
    let place = path.to_path_buf();
    let waiting = std::thread::Builder::new().name("output".to_string()).spawn(move || {
        // The receiver is gone if the run was interrupted.
        let _ = opened.send(OpenOptions::new().write(true).open(place));
    });
    waiting.map_err(|reason| LogError::Write { path: path.to_path_buf(), reason })?;
    loop {
        match wait.recv_timeout(INTERVAL) {
            Ok(file) => return Ok(file.ok()),
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
            Err(RecvTimeoutError::Timeout) if interrupted.load(Ordering::Relaxed) => {
                return Err(Error::Unread { path: path.to_path_buf() });
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

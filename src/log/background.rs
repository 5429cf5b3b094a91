//! Writes the log on a thread of its own, because a disk may let it wait.
//!
//! The simulation puts messages into a batch that both threads know, sample by sample; the thread takes the batch when
//! it is large, or a tenth of a second has passed, whatever the simulation does meanwhile. If more waits than
//! [`LARGEST_WAIT`], the simulation waits too. What the file becomes does not depend on when batches were taken.

use super::batch::Batch;
use super::file::{Ending, LogError, LogFile};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// The thread is woken when so many bytes wait…
const PIECE_SIZE: usize = 1 << 18;

/// … and looks by itself this often, so that a killed run leaves little unsaid.
const INTERVAL: Duration = Duration::from_millis(100);

/// More bytes than this do not wait.
const LARGEST_WAIT: usize = 1 << 22;

/// A log file that is written by another thread.
pub(super) struct BackgroundFile {
    path: PathBuf,
    current: PathBuf,
    is_beside: bool,
    piece: Batch,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<PathBuf, LogError>>>,
}

#[derive(Default)]
struct Shared {
    waiting: Mutex<Waiting>,
    /// There is something for the thread.
    news: Condvar,
    /// There is room for the simulation.
    room: Condvar,
}

#[derive(Default)]
struct Waiting {
    batch: Batch,
    ending: Option<Ending>,
    /// The thread cannot write any more.
    failed: bool,
    /// The simulation is gone without an ending.
    abandoned: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl BackgroundFile {
    /// Goes on writing `file` on a new thread.
    ///
    /// # Errors
    /// [`LogError::Write`] if there can be no thread.
    pub(super) fn new(path: &Path, file: LogFile) -> Result<Self, LogError> {
        let shared = Arc::new(Shared::default());
        let current = file.current().to_path_buf();
        let is_beside = file.is_beside();
        let theirs = shared.clone();
        let thread = std::thread::Builder::new().name("log".to_string()).spawn(move || write(file, &theirs));
        let thread = thread.map_err(|reason| LogError::Write { path: path.to_path_buf(), reason })?;
        Ok(BackgroundFile {
            path: path.to_path_buf(),
            current,
            is_beside,
            piece: Batch::default(),
            shared,
            thread: Some(thread),
        })
    }

    /// Where the file is while it is written.
    pub(super) fn current(&self) -> &Path {
        &self.current
    }

    /// Whether that is beside its output.
    pub(super) fn is_beside(&self) -> bool {
        self.is_beside
    }

    /// The messages that will be handed over next.
    pub(super) fn piece(&mut self) -> &mut Batch {
        &mut self.piece
    }

    /// Hands the messages over.
    ///
    /// # Errors
    /// [`LogError::Write`] if earlier messages could not be written.
    pub(super) fn settle(&mut self) -> Result<(), LogError> {
        let mut waiting = self.shared.lock();
        while waiting.batch.size() > LARGEST_WAIT && !waiting.failed {
            waiting = self.shared.room.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
        if waiting.failed {
            drop(waiting);
            return self.join().map(|_| ());
        }
        waiting.batch.append(&self.piece);
        let is_large = waiting.batch.size() >= PIECE_SIZE;
        drop(waiting);
        self.piece.clear();
        if is_large {
            self.shared.news.notify_one();
        }
        Ok(())
    }

    /// Waits for the thread, which completes the file.
    fn join(&mut self) -> Result<PathBuf, LogError> {
        let lost = || {
            let reason = std::io::Error::other("the thread that writes the log has ended");
            Err(LogError::Write { path: self.path.clone(), reason })
        };
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(ended)) => ended,
            Some(Err(_)) | None => lost(),
        }
    }

    /// Hands over what is left and completes the file. Returns where it is.
    ///
    /// # Errors
    /// [`LogError::Write`], also for earlier messages.
    pub(super) fn finish(mut self, ending: Ending) -> Result<PathBuf, LogError> {
        self.settle()?;
        self.shared.lock().ending = Some(ending);
        self.shared.news.notify_one();
        self.join()
    }
}

impl Drop for BackgroundFile {
    /// Without an ending the file stays as a killed run leaves it.
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            self.shared.lock().abandoned = true;
            self.shared.news.notify_one();
            let _ = thread.join();
        }
    }
}

/// The thread: writes until there is no more, and completes the file.
fn write(mut file: LogFile, shared: &Shared) -> Result<PathBuf, LogError> {
    let ended = write_all(&mut file, shared);
    if ended.is_err() {
        shared.lock().failed = true;
        shared.room.notify_one();
        file.salvage();
    }
    ended
}

fn write_all(file: &mut LogFile, shared: &Shared) -> Result<PathBuf, LogError> {
    let mut taken = Batch::default();
    loop {
        let is_idle =
            |waiting: &mut Waiting| waiting.batch.size() < PIECE_SIZE && waiting.ending.is_none() && !waiting.abandoned;
        let waited = shared.news.wait_timeout_while(shared.lock(), INTERVAL, is_idle);
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        taken.clear();
        std::mem::swap(&mut taken, &mut waiting.batch);
        let (ending, abandoned) = (waiting.ending.take(), waiting.abandoned);
        drop(waiting);
        shared.room.notify_one();
        file.append(&taken)?;
        if let Some(ending) = ending {
            return file.finish(&ending);
        }
        file.save_if_due()?;
        if abandoned {
            return Ok(file.current().to_path_buf());
        }
    }
}

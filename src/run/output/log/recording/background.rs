//! Encodes and writes the log on a separate thread, so that the simulation does not wait for encoding or for the disk.
//!
//! The simulation puts samples into a piece that both threads know, as positions and velocities. The thread takes the piece when it is large, or a
//! tenth of a second has passed, without regard to the simulation. If it is too large, the simulation waits too. The content of the file does not
//! depend on when pieces were taken.

use crate::output::log::encoding::ending::Ending;
use crate::output::log::recording::encoder::SampleEncoder;
use crate::output::log::recording::queue::Piece;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::LogFile;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The thread is woken when there is a large piece, and looks by itself this often, so that a killed run leaves little unsaid.
const INTERVAL: Duration = Duration::from_millis(100);

/// Once the run is interrupted, the wait for a pipe or device that takes no bytes ends after this time.
const GRACE: Duration = Duration::from_secs(1);

/// A log file that is written by another thread.
pub(crate) struct BackgroundFile {
    path: PathBuf,
    current: PathBuf,
    is_beside: bool,
    /// The flag of an interrupted run, for a pipe or device, whose reader may never read again.
    interrupted: Option<Arc<AtomicBool>>,
    is_regular: bool,
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
    /// How often the thread has come round.
    rounds: AtomicUsize,
}

#[derive(Default)]
struct Waiting {
    piece: Piece,
    /// The run has restarted, and `piece` is of that.
    again: bool,
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
    /// Goes on writing `file` on a new thread, with the messages of `encoder`.
    ///
    /// # Errors
    /// [`LogError::Write`] if there can be no thread.
    pub(crate) fn new(path: &Path, file: LogFile, encoder: SampleEncoder) -> Result<Self, LogError> {
        let shared = Arc::new(Shared::default());
        let current = file.current().to_path_buf();
        let (is_beside, is_regular) = (file.is_beside(), file.is_regular());
        let theirs = shared.clone();
        let thread = std::thread::Builder::new().name("log".to_string()).spawn(move || write(file, encoder, &theirs));
        let thread = thread.map_err(|reason| LogError::Write { path: path.to_path_buf(), reason })?;
        let path = path.to_path_buf();
        Ok(BackgroundFile { path, current, is_beside, interrupted: None, is_regular, shared, thread: Some(thread) })
    }

    /// Gives up an output that blocks once this says that the run is interrupted.
    pub(crate) fn heed(&mut self, interrupted: Arc<AtomicBool>) {
        self.interrupted = Some(interrupted).filter(|_| !self.is_regular);
    }

    /// Waits while `waits`, unless the run is interrupted and the thread does not come round any more; returns whether it does.
    fn wait_while(&self, waits: impl Fn() -> bool) -> bool {
        let rounds = || self.shared.rounds.load(Ordering::Relaxed);
        let (mut seen, mut since) = (rounds(), Instant::now());
        while waits() {
            let waiting = self.shared.lock();
            let _ = self.shared.room.wait_timeout(waiting, INTERVAL / 10);
            let interrupted = self.interrupted.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed));
            if !interrupted || rounds() != seen {
                (seen, since) = (rounds(), Instant::now());
            } else if since.elapsed() > GRACE {
                return false;
            }
        }
        true
    }

    /// Waits no more for the thread, which blocks, and says so.
    fn give_up(&mut self) -> LogError {
        self.thread = None;
        LogError::Blocked { path: self.path.clone() }
    }

    /// The place of the file while it is written.
    pub(crate) fn current(&self) -> &Path {
        &self.current
    }

    /// Whether that is beside its output.
    pub(crate) fn is_beside(&self) -> bool {
        self.is_beside
    }

    /// Lets `add` add to what the thread will take; returns whether [`BackgroundFile::settle`] has something to say.
    pub(crate) fn add(&self, add: impl FnOnce(&mut Piece)) -> bool {
        let mut waiting = self.shared.lock();
        let was_large = waiting.piece.is_large();
        add(&mut waiting.piece);
        let (is_large, stop) = (waiting.piece.is_large(), waiting.failed || waiting.piece.is_too_large());
        drop(waiting);
        if is_large && !was_large {
            self.shared.news.notify_one();
        }
        stop
    }

    /// Everything since the run began is void: it restarts.
    pub(crate) fn begin_again(&self) {
        let mut waiting = self.shared.lock();
        waiting.piece.clear();
        waiting.again = true;
    }

    /// Waits until there is room.
    ///
    /// # Errors
    /// [`LogError::Write`] if earlier messages could not be written.
    pub(crate) fn settle(&mut self) -> Result<(), LogError> {
        if self.interrupted.is_some() {
            let waits = || {
                let waiting = self.shared.lock();
                waiting.piece.is_too_large() && !waiting.failed
            };
            if !self.wait_while(waits) {
                return Err(self.give_up());
            }
        }
        let mut waiting = self.shared.lock();
        while waiting.piece.is_too_large() && !waiting.failed {
            waiting = self.shared.room.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
        let failed = waiting.failed;
        drop(waiting);
        if failed { self.join().map(drop) } else { Ok(()) }
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

    /// Has everything written and the file completed. Returns where it is.
    ///
    /// # Errors
    /// [`LogError::Write`], also for earlier messages.
    pub(crate) fn finish(mut self, ending: Ending) -> Result<PathBuf, LogError> {
        self.settle()?;
        self.shared.lock().ending = Some(ending);
        self.shared.news.notify_one();
        let ends = |thread: &JoinHandle<_>| thread.is_finished();
        if self.interrupted.is_some() && !self.wait_while(|| !self.thread.as_ref().is_none_or(ends)) {
            return Err(self.give_up());
        }
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
fn write(mut file: LogFile, encoder: SampleEncoder, shared: &Shared) -> Result<PathBuf, LogError> {
    let _gone = Gone(shared);
    let ended = write_all(&mut file, encoder, shared);
    if ended.is_err() {
        shared.lock().failed = true;
        file.salvage(&|| went_on(shared));
    }
    ended
}

/// The thread does not wait for a reader.
fn went_on(shared: &Shared) {
    shared.rounds.fetch_add(1, Ordering::Relaxed);
}

/// However the thread ends, no other thread waits for it afterwards.
struct Gone<'s>(&'s Shared);

impl Drop for Gone<'_> {
    fn drop(&mut self) {
        self.0.lock().failed = true;
        self.0.room.notify_one();
    }
}

fn write_all(file: &mut LogFile, mut encoder: SampleEncoder, shared: &Shared) -> Result<PathBuf, LogError> {
    let mut taken = Piece::default();
    loop {
        let is_idle =
            |waiting: &mut Waiting| !waiting.piece.is_large() && waiting.ending.is_none() && !waiting.abandoned;
        let waited = shared.news.wait_timeout_while(shared.lock(), INTERVAL, is_idle);
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        taken.clear();
        std::mem::swap(&mut taken, &mut waiting.piece);
        let (ending, abandoned) = (waiting.ending.take(), waiting.abandoned);
        let again = std::mem::take(&mut waiting.again);
        went_on(shared);
        drop(waiting);
        shared.room.notify_one();
        if again {
            file.begin_again()?;
        }
        encoder.encode(&taken, file)?;
        if let Some(ending) = ending {
            return file.finish(&ending, &|| went_on(shared));
        }
        file.save_if_due()?;
        if abandoned {
            file.release(&|| went_on(shared))?;
            return Ok(file.current().to_path_buf());
        }
    }
}

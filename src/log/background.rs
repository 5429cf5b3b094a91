//! Writes the log on a thread of its own, because compression takes longer than everything else about a log.
//!
//! The simulation hands over messages in pieces, of which a few may wait; then it waits too. What the file becomes does
//! not depend on how the messages were cut into pieces.

use super::batch::Batch;
use super::file::{LogError, LogFile, PROVISIONAL_INTERVAL};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Pieces are handed over when they have this many bytes…
const PIECE_SIZE: usize = 1 << 16;

/// … or when this much time has passed, so that a killed run leaves little unsaid.
const PIECE_INTERVAL: Duration = Duration::from_millis(100);

/// Pieces that may wait for the thread.
const WAITING_PIECES: usize = 16;

/// A log file that is written by another thread.
pub(super) struct BackgroundFile {
    path: PathBuf,
    piece: Batch,
    handed_over: Instant,
    sender: Option<SyncSender<Batch>>,
    thread: Option<JoinHandle<Result<(), LogError>>>,
}

impl BackgroundFile {
    /// Goes on writing `file` on a new thread.
    ///
    /// # Errors
    /// [`LogError::Write`] if there can be no thread.
    pub(super) fn new(path: &Path, file: LogFile) -> Result<Self, LogError> {
        let (sender, receiver) = sync_channel(WAITING_PIECES);
        let thread = std::thread::Builder::new().name("log".to_string()).spawn(move || write(file, &receiver));
        let thread = thread.map_err(|reason| LogError::Write { path: path.to_path_buf(), reason })?;
        Ok(BackgroundFile {
            path: path.to_path_buf(),
            piece: Batch::default(),
            handed_over: Instant::now(),
            sender: Some(sender),
            thread: Some(thread),
        })
    }

    /// The messages that will be handed over next.
    pub(super) fn piece(&mut self) -> &mut Batch {
        &mut self.piece
    }

    /// Hands the messages over if it is time.
    ///
    /// # Errors
    /// [`LogError::Write`] if earlier messages could not be written.
    pub(super) fn settle(&mut self) -> Result<(), LogError> {
        if self.piece.size() >= PIECE_SIZE || self.handed_over.elapsed() >= PIECE_INTERVAL {
            self.hand_over()?;
        }
        Ok(())
    }

    fn hand_over(&mut self) -> Result<(), LogError> {
        self.handed_over = Instant::now();
        let piece = std::mem::take(&mut self.piece);
        match &self.sender {
            Some(sender) if sender.send(piece).is_ok() => Ok(()),
            // The thread has ended, which it does before it is told to only if it cannot write.
            _ => self.join(),
        }
    }

    /// Waits for the thread, which completes the file.
    fn join(&mut self) -> Result<(), LogError> {
        self.sender = None;
        let ended = self.thread.take().map(JoinHandle::join);
        ended.unwrap_or(Ok(Ok(()))).unwrap_or_else(|_| {
            let reason = std::io::Error::other("the thread that writes the log has ended");
            Err(LogError::Write { path: self.path.clone(), reason })
        })
    }

    /// Hands over what is left and completes the file.
    ///
    /// # Errors
    /// [`LogError::Write`], also for earlier messages.
    pub(super) fn finish(mut self) -> Result<(), LogError> {
        self.hand_over()?;
        self.join()
    }
}

/// The thread: writes until there is no more, and completes the file.
fn write(mut file: LogFile, pieces: &Receiver<Batch>) -> Result<(), LogError> {
    loop {
        match pieces.recv_timeout(PROVISIONAL_INTERVAL) {
            Ok(piece) => file.append(&piece)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return file.finish(),
        }
        file.save_if_due()?;
    }
}

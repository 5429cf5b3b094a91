//! The frames of a log one after the other, read by a thread.

use crate::output::log::reading::frames::{Frame, Visitor, visit};
use crate::output::log::reading::records::{Completeness, ReadError};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Frames that are handed over together.
const PIECE: usize = 64;

/// Some frames.
struct FramePiece {
    frames: Vec<Frame>,
    /// Whether they are the last.
    is_last: bool,
    /// How much of the log there was, if they are.
    completeness: Option<Completeness>,
}

/// The frames of a log one after the other, read by a thread.
pub struct Frames {
    receiver: Receiver<Result<FramePiece, ReadError>>,
    ready: std::vec::IntoIter<Frame>,
    has_ended: bool,
    completeness: Option<Completeness>,
    path: PathBuf,
}

impl Frames {
    /// Starts to read a log.
    ///
    /// # Errors
    /// [`ReadError::Io`] if there can be no thread.
    pub fn of(path: &Path) -> Result<Self, ReadError> {
        let (sender, receiver) = sync_channel(4);
        let log = path.to_path_buf();
        let read = move || {
            let mut collector = Sender { sender, piece: Vec::new() };
            let ended = visit(&log, &mut collector);
            let last = |completeness| FramePiece { frames: collector.piece, is_last: true, completeness };
            let _ = collector.sender.send(ended.map(last));
        };
        let thread = std::thread::Builder::new().name("log".to_string()).spawn(read);
        thread.map_err(|reason| ReadError::Io { path: path.to_path_buf(), reason })?;
        let path = path.to_path_buf();
        Ok(Frames { receiver, ready: Vec::new().into_iter(), has_ended: false, completeness: None, path })
    }

    /// How much of the log there was, once there are no more frames.
    pub fn completeness(&self) -> Option<&Completeness> {
        self.completeness.as_ref()
    }
}

impl Iterator for Frames {
    type Item = Result<Frame, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(frame) = self.ready.next() {
                return Some(Ok(frame));
            }
            if self.has_ended {
                return None;
            }
            match self.receiver.recv() {
                Ok(Ok(FramePiece { frames, is_last, completeness })) => {
                    (self.ready, self.has_ended, self.completeness) = (frames.into_iter(), is_last, completeness);
                }
                Ok(Err(error)) => {
                    self.has_ended = true;
                    return Some(Err(error));
                }
                // A thread that ends without a last piece has broken off.
                Err(_) => {
                    self.has_ended = true;
                    let reason = std::io::Error::other("what reads it has broken off");
                    return Some(Err(ReadError::Io { path: self.path.clone(), reason }));
                }
            }
        }
    }
}

struct Sender {
    sender: SyncSender<Result<FramePiece, ReadError>>,
    piece: Vec<Frame>,
}

impl Visitor for Sender {
    fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
        self.piece.push(frame.clone());
        if self.piece.len() < PIECE {
            return ControlFlow::Continue(());
        }
        let frames = std::mem::take(&mut self.piece);
        match self.sender.send(Ok(FramePiece { frames, is_last: false, completeness: None })) {
            Ok(()) => ControlFlow::Continue(()),
            // The receiver of the frames is gone.
            Err(_) => ControlFlow::Break(()),
        }
    }
}

//! The MCAP file under the log: batches of messages, and a file that is readable whenever the process is killed.
//!
//! Messages are collected in memory and written as one chunk ([`Container`]) whenever the next would not fit into [`CHUNK_SIZE`]. The ends of chunks
//! depend on the messages alone, so equal runs give equal files. A slow run would then leave little behind when it is killed. So twice a second the
//! new messages of the open batch are written as a provisional chunk. When the batch is complete, its chunk takes their place ([`Tail`]):
//!
//! ```text
//!     magic  header  metadata  attachment | chunk | chunk | … | chunk | provisional chunks       a running simulation
//!     magic  header  metadata  attachment | chunk | chunk | … | chunk | metadata  summary  magic   a finished file
//! ```
//!
//! Chunks are compressed ([`Packing`]), provisional ones are not.
//!
//! Only regular files have such a provisional end; pipes and devices get final bytes only. If the run may begin again, they get the constant part,
//! and the rest when the run has ended ([`crate::output::log::storage::spool`]). When a write fails because the disk is full, the whole part is kept
//! and closed with an end that needs no summary.

use crate::output::log::encoding::definitions::Definition;
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::ending::{Ending, Outcome};
use crate::output::log::encoding::names::{END, LIBRARY_VERSION, OUTCOME};
use crate::output::log::storage::batch::Batch;
use crate::output::log::storage::compression::Packing;
use crate::output::log::storage::container::{Container, encode_piece, encode_provisional_chunk};
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::output::Output;
use crate::output::log::storage::place::{FilePlace, Tail};
use crate::output::log::storage::spool::LogPlace;
use mcap::records::Metadata;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Largest size of a chunk of several messages.
const CHUNK_SIZE: usize = 1 << 18;

/// Largest size of a chunk of several messages that is written once a disk is full: it loses no more than that.
const PIECE_SIZE: usize = 1 << 15;

/// Between two provisional chunks; with the time messages wait before and the write itself, less than a second of the
/// run is lost when the process is killed.
const PROVISIONAL_INTERVAL: Duration = Duration::from_millis(500);

/// An MCAP file being written.
pub(crate) struct LogFile {
    /// The output as the user named it.
    path: PathBuf,
    output: Output,
    tail: Tail<LogPlace>,
    is_regular: bool,
    container: Container,
    /// That before the first sample.
    head: Option<Box<Container>>,
    /// How the chunks that come now are packed.
    packing: Packing,
    /// Whether chunks of samples will be packed by Zstandard.
    compress: bool,
    /// The messages that are in no final chunk yet.
    batch: Batch,
    /// How many of them are in provisional chunks.
    provisional: usize,
    /// The chunk that is being encoded.
    buffer: Vec<u8>,
    saved: Instant,
    /// Whether something was written that may still be lost in a power failure.
    unsynced: bool,
    /// Whether a write has failed that left messages of the batch out of the file.
    unwritten: bool,
}

impl LogFile {
    /// Creates a file for the output `path` ([`Output`]); `compress`: whether samples will be packed by Zstandard.
    ///
    /// # Errors
    /// [`LogError::Create`] and [`LogError::Busy`] if that is not possible, [`LogError::Write`] if its first bytes
    /// cannot be written.
    pub(crate) fn create(path: &Path, compress: bool) -> Result<Self, LogError> {
        let (output, file, is_regular) = Output::create(path)?;
        let container = Container::new(LIBRARY_VERSION);
        let container = container.map_err(|error| cannot_encode(path, error))?;
        let packing = Packing::new(true).map_err(|error| cannot_encode(path, error.into()))?;
        Ok(LogFile {
            path: path.to_path_buf(),
            output,
            tail: Tail::new(LogPlace::new(FilePlace::new(file, is_regular))),
            is_regular,
            container,
            head: None,
            packing,
            compress,
            batch: Batch::default(),
            provisional: 0,
            buffer: Vec::new(),
            saved: Instant::now(),
            unsynced: false,
            unwritten: false,
        })
    }

    /// Whether it is a file, and not a pipe or device.
    pub(crate) fn is_regular(&self) -> bool {
        self.is_regular
    }

    /// The place of the file now.
    pub(crate) fn current(&self) -> &Path {
        self.output.current()
    }

    /// Whether that is beside its output.
    pub(crate) fn is_beside(&self) -> bool {
        self.output.protects()
    }

    /// Ends the constant part: writes it, and lets the file take its place unless a finished log there must stay. `may_begin_again`: a pipe or device
    /// gets no more until the end.
    pub(crate) fn begin(&mut self, may_begin_again: bool) -> Result<(), LogError> {
        self.close_batch()?;
        if may_begin_again && !self.is_regular {
            let final_part = self.tail.whole();
            self.tail.place().hold(final_part);
        }
        self.packing = Packing::new(self.compress).map_err(|error| cannot_encode(&self.path, error.into()))?;
        self.head = (self.is_regular || may_begin_again).then(|| Box::new(self.container.clone()));
        self.output.settle(false).map_err(|reason| self.cannot_write(reason))
    }

    /// Cuts off everything since [`LogFile::begin`]: the run restarts. Pipes and devices that were not told then keep their bytes, and get all of
    /// them again.
    pub(crate) fn begin_again(&mut self) -> Result<(), LogError> {
        self.batch.clear();
        self.provisional = 0;
        if let Some(head) = &self.head {
            self.container.clone_from(head);
            let length = self.container.length();
            self.tail.cut_to(length).map_err(|reason| self.cannot_write(reason))?;
            self.unsynced = true;
        }
        Ok(())
    }

    /// Adds a metadata record.
    pub(crate) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), LogError> {
        let record = Metadata { name: name.to_string(), metadata };
        self.container.metadata(&record).map_err(|error| cannot_encode(&self.path, error))
    }

    /// Adds an attachment.
    pub(crate) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), LogError> {
        let attached = self.container.attach(name, media_type, data);
        attached.map_err(|error| cannot_encode(&self.path, error))
    }

    /// Writes the collected messages as a final chunk, through to the operating system.
    fn close_batch(&mut self) -> Result<(), LogError> {
        self.move_to_file()?;
        let chunk = self.container.chunk(&self.batch, &mut self.packing, &mut self.buffer);
        chunk.map_err(|error| cannot_encode(&self.path, error))?;
        let whole = self.tail.whole();
        let written = self.tail.extend(&self.buffer);
        // Otherwise all of it is there, though not where it should be.
        self.unwritten = written.is_err() && self.tail.whole() == whole;
        written.map_err(|reason| self.cannot_write(reason))?;
        self.batch.clear();
        self.provisional = 0;
        Ok(())
    }

    fn move_to_file(&mut self) -> Result<(), LogError> {
        self.unsynced = true;
        let LogFile { container, tail, .. } = self;
        container.take(|bytes| tail.extend(bytes)).map_err(|reason| self.cannot_write(reason))
    }

    fn cannot_write(&self, reason: io::Error) -> LogError {
        LogError::Write { path: self.path.clone(), reason }
    }

    /// Makes everything up to now safe, if that was last done long enough ago.
    pub(crate) fn save_if_due(&mut self) -> Result<(), LogError> {
        if self.is_regular && self.saved.elapsed() >= PROVISIONAL_INTERVAL {
            self.save()?;
            self.saved = Instant::now();
        }
        Ok(())
    }

    fn save(&mut self) -> Result<(), LogError> {
        if self.batch.count() > self.provisional {
            self.buffer.clear();
            let encoded = encode_provisional_chunk(&self.batch, self.provisional, &mut self.buffer);
            encoded.map_err(|error| cannot_encode(&self.path, error))?;
            let written = self.tail.extend_provisionally(&self.buffer);
            self.unwritten = written.is_err();
            written.map_err(|reason| self.cannot_write(reason))?;
            self.provisional = self.batch.count();
            self.unsynced = true;
        }
        if std::mem::take(&mut self.unsynced) {
            self.tail.sync().map_err(|reason| self.cannot_write(reason))?;
        }
        Ok(())
    }

    /// Completes the file: everything collected, how the run ended, and the summary, without a provisional part after it; then lets it take its
    /// place. Returns its path. `went_on` is called whenever a pipe or device has taken bytes that were held back.
    ///
    /// # Errors
    /// [`LogError::Write`], as for every message.
    pub(crate) fn finish(&mut self, ending: &Ending, went_on: &dyn Fn()) -> Result<PathBuf, LogError> {
        if self.batch.count() > 0 {
            self.close_batch()?;
        }
        let mut entries = ending.figures.clone();
        entries.insert(OUTCOME.to_string(), ending.outcome.name().to_string());
        self.metadata(END, entries)?;
        self.container.finish().map_err(|error| cannot_encode(&self.path, error))?;
        self.move_to_file()?;
        self.release(went_on)?;
        // A short run ends within the second that may be lost, unless it replaces a finished log.
        let finished = ending.outcome == Outcome::Finished;
        let is_due = self.saved.elapsed() >= PROVISIONAL_INTERVAL || self.output.protects();
        let synced = if is_due { self.tail.sync() } else { Ok(()) };
        synced.and_then(|()| self.output.settle(finished)).map_err(|reason| self.cannot_write(reason))?;
        Ok(self.current().to_path_buf())
    }

    /// Hands on the bytes that were held back.
    pub(crate) fn release(&mut self, went_on: &dyn Fn()) -> Result<(), LogError> {
        self.tail.place().release(went_on).map_err(|reason| self.cannot_write(reason))
    }

    /// After an error: keeps the whole part of the file, or the bytes that were held back, and completes it as well as possible.
    pub(crate) fn salvage(&mut self, went_on: &dyn Fn()) {
        if !self.is_regular && !self.tail.place().holds() {
            return;
        }
        let last = if self.unwritten { self.write_pieces() } else { 0 };
        // The error that led here is the one to report.
        if self.tail.end_short().is_err() && last > 0 && self.tail.cut(last).is_ok() {
            let _ = self.tail.end_short();
        }
        let _ = self.release(went_on);
    }

    /// Writes the messages of the batch that are not in the file in small chunks, as many as there is room for; returns the length of the last.
    fn write_pieces(&mut self) -> u64 {
        let (mut first, mut last) = (self.provisional, 0);
        while first < self.batch.count() && self.tail.cut(0).is_ok() {
            self.buffer.clear();
            let Ok(count) = encode_piece(&self.batch, first, PIECE_SIZE, &mut self.buffer) else { break };
            if self.tail.extend_provisionally(&self.buffer).is_err() {
                break;
            }
            first += count;
            last = self.buffer.len() as u64;
        }
        last
    }
}

/// Something that messages are for: a file, or the log they are held against.
pub(crate) trait MessageSink {
    /// Adds a channel for messages of this definition and returns its identifier.
    fn channel(&mut self, topic: &str, definition: &Definition, durability: Durability) -> Result<u16, LogError>;

    /// Adds a message like `template`; returns its data.
    fn message(&mut self, channel: u16, nanoseconds: u64, template: &[u8]) -> Result<&mut [u8], LogError>;
}

impl MessageSink for LogFile {
    fn channel(&mut self, topic: &str, definition: &Definition, durability: Durability) -> Result<u16, LogError> {
        let channel = self.container.channel(topic, definition, durability, &mut self.batch);
        let channel = channel.map_err(|error| cannot_encode(&self.path, error))?;
        channel.ok_or_else(|| self.cannot_write(io::Error::other("there are more topics than a log can have")))
    }

    /// Writes a chunk whenever one is full.
    fn message(&mut self, channel: u16, nanoseconds: u64, template: &[u8]) -> Result<&mut [u8], LogError> {
        if self.batch.count() > 0 && self.batch.size_with(template) > CHUNK_SIZE {
            self.close_batch()?;
        }
        Ok(self.batch.push(channel, nanoseconds, template))
    }
}

fn cannot_encode(path: &Path, error: binrw::Error) -> LogError {
    LogError::Write { path: path.to_path_buf(), reason: io::Error::other(error) }
}

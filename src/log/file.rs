//! The MCAP file under the log: batches of messages, and a file that is readable whenever the process is killed.
//!
//! Messages are collected in memory and written as one compressed chunk whenever the next would not fit into
//! [`CHUNK_SIZE`]. Where chunks end depends on the messages alone, which makes equal runs give equal files. A run that
//! is slow would then leave little behind when it is killed; so twice a second what is new in the batch that is still
//! open is written as a provisional chunk, until the batch is complete and its chunk takes their place ([`Tail`]):
//!
//! ```text
//!     magic  header  metadata  attachment | chunk | chunk | … | chunk | provisional chunks       a running simulation
//!     magic  header  metadata  attachment | chunk | chunk | … | chunk | metadata  summary  magic   a finished file
//! ```
//!
//! Only regular files have such a provisional end; into pipes and devices nothing is written that is not final. When a
//! write fails because the disk is full, what is whole is kept and closed with an end that needs no summary.

use super::batch::Batch;
use super::output::{END, FINISHED, OUTCOME, Output};
use super::place::{FilePlace, Tail};
use mcap::records::Metadata;
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Largest uncompressed size of a chunk of several messages.
const CHUNK_SIZE: usize = 1 << 20;

/// Between two provisional chunks; with the time messages wait before and the write itself, less than a second of the
/// run is lost when the process is killed.
const PROVISIONAL_INTERVAL: Duration = Duration::from_millis(500);

/// Why the log could not be written.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file could not be created; nothing was changed.
    #[error("cannot create {}: {reason}", path.display())]
    Create { path: PathBuf, reason: io::Error },
    /// Another run is writing the file; nothing was changed.
    #[error("cannot write {}: another run is writing it; choose another --output", path.display())]
    Busy { path: PathBuf },
    /// Writing failed: a full disk, a closed pipe.
    #[error("cannot write {}: {reason}", path.display())]
    Write { path: PathBuf, reason: io::Error },
}

/// How a run ended, for the last record of its log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ending {
    /// The way it ended.
    pub outcome: Outcome,
    /// Figures of the whole run, by name.
    pub figures: BTreeMap<String, String>,
}

/// The ways a run ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// It reached its end.
    #[default]
    Finished,
    /// The user ended it.
    Interrupted,
    /// It could not go on.
    Failed,
}

impl Outcome {
    /// The word in the log.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Finished => FINISHED,
            Outcome::Interrupted => "interrupted",
            Outcome::Failed => "failed",
        }
    }
}

/// A channel of the log, in the order of creation: topic, schema (name, encoding, data), message encoding.
struct Channel {
    topic: String,
    schema: (String, String, Vec<u8>),
    encoding: String,
}

/// An MCAP file being written.
pub(super) struct LogFile {
    /// The output as the user named it.
    path: PathBuf,
    output: Output,
    tail: Tail<FilePlace>,
    is_regular: bool,
    writer: Writer<Sink>,
    /// What the writer has written and the file has not.
    written: Pending,
    channels: Vec<Channel>,
    /// The messages that are in no final chunk yet.
    batch: Batch,
    provisional: Option<Provisional>,
    saved: Instant,
    /// Whether something was written that may still be lost in a power failure.
    unsynced: bool,
}

/// The writer of provisional chunks.
struct Provisional {
    writer: Writer<Sink>,
    written: Pending,
    /// Messages of the open batch that are in provisional chunks.
    messages: usize,
}

impl LogFile {
    /// Creates a file for the output `path` ([`Output`]).
    ///
    /// # Errors
    /// [`LogError::Create`] and [`LogError::Busy`] if that is not possible, [`LogError::Write`] if its first bytes
    /// cannot be written.
    pub(super) fn create(path: &Path) -> Result<Self, LogError> {
        let (output, file, is_regular) = Output::create(path)?;
        let written = Pending::default();
        let sink = Sink { pending: written.clone(), position: 0 };
        let writer = write_options().create(sink).map_err(|error| write_error(path, error))?;
        Ok(LogFile {
            path: path.to_path_buf(),
            output,
            tail: Tail::new(FilePlace::new(file, is_regular)),
            is_regular,
            writer,
            written,
            channels: Vec::new(),
            batch: Batch::default(),
            provisional: None,
            saved: Instant::now(),
            unsynced: false,
        })
    }

    /// Where the file is now.
    pub(super) fn current(&self) -> &Path {
        self.output.current()
    }

    /// Whether that is beside its output.
    pub(super) fn is_beside(&self) -> bool {
        self.output.protects()
    }

    /// Ends what never changes: writes it, and lets the file take its place if nothing there must stay.
    pub(super) fn begin(&mut self) -> Result<(), LogError> {
        self.close_batch()?;
        self.output.settle(false).map_err(|reason| LogError::Write { path: self.path.clone(), reason })
    }

    /// Writes a metadata record.
    pub(super) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), LogError> {
        let record = Metadata { name: name.to_string(), metadata };
        self.writer.write_metadata(&record).map_err(|error| write_error(&self.path, error))
    }

    /// Writes an attachment.
    pub(super) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), LogError> {
        let attachment = Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_string(),
            media_type: media_type.to_string(),
            data: data.into(),
        };
        self.writer.attach(&attachment).map_err(|error| write_error(&self.path, error))
    }

    /// Adds messages and writes a chunk whenever one is full.
    pub(super) fn append(&mut self, messages: &Batch) -> Result<(), LogError> {
        for (header, data) in messages.messages() {
            if self.batch.count() > 0 && self.batch.size_with(data.len()) > CHUNK_SIZE {
                self.close_batch()?;
            }
            self.batch.push_message(header, data);
        }
        Ok(())
    }

    /// Writes what has been collected as a final chunk, through to the operating system.
    fn close_batch(&mut self) -> Result<(), LogError> {
        let closed = self.batch.write_to(&mut self.writer, 0).and_then(|()| self.writer.flush());
        closed.map_err(|error| write_error(&self.path, error))?;
        self.move_to_file()?;
        self.batch.clear();
        if let Some(provisional) = &mut self.provisional {
            provisional.messages = 0;
        }
        Ok(())
    }

    fn move_to_file(&mut self) -> Result<(), LogError> {
        let bytes = self.written.take();
        self.unsynced = true;
        self.tail.extend(&bytes).map_err(|reason| LogError::Write { path: self.path.clone(), reason })
    }

    /// Makes everything up to now safe, if that was last done long enough ago.
    pub(super) fn save_if_due(&mut self) -> Result<(), LogError> {
        if self.is_regular && self.saved.elapsed() >= PROVISIONAL_INTERVAL {
            self.save().map_err(|error| write_error(&self.path, error))?;
            self.saved = Instant::now();
        }
        Ok(())
    }

    fn save(&mut self) -> Result<(), McapError> {
        let provisional = match &mut self.provisional {
            Some(provisional) => provisional,
            None => self.provisional.insert(Provisional::new(&self.channels)?),
        };
        if self.batch.count() > provisional.messages {
            self.batch.write_to(&mut provisional.writer, provisional.messages)?;
            provisional.writer.flush()?;
            provisional.messages = self.batch.count();
            self.tail.extend_provisionally(&provisional.written.take())?;
            self.unsynced = true;
        }
        if std::mem::take(&mut self.unsynced) {
            self.tail.sync()?;
        }
        Ok(())
    }

    /// Completes the file: everything collected, how the run ended, the summary, and nothing provisional after it; then
    /// lets it take its place. Returns where it is.
    ///
    /// # Errors
    /// [`LogError::Write`], as for every message.
    pub(super) fn finish(&mut self, ending: &Ending) -> Result<PathBuf, LogError> {
        if self.batch.count() > 0 {
            self.close_batch()?;
        }
        let mut entries = ending.figures.clone();
        entries.insert(OUTCOME.to_string(), ending.outcome.name().to_string());
        self.metadata(END, entries)?;
        self.writer.finish().map_err(|error| write_error(&self.path, error))?;
        self.move_to_file()?;
        // A short run ends within the second that may be lost, unless it replaces what must not be lost.
        let finished = ending.outcome == Outcome::Finished;
        let is_due = self.saved.elapsed() >= PROVISIONAL_INTERVAL || self.output.protects();
        let synced = if is_due { self.tail.sync() } else { Ok(()) };
        let settled = synced.and_then(|()| self.output.settle(finished));
        settled.map_err(|reason| LogError::Write { path: self.path.clone(), reason })?;
        Ok(self.current().to_path_buf())
    }

    /// After an error: keeps what is whole in the file and completes it as well as that goes.
    pub(super) fn salvage(&mut self) {
        if self.is_regular {
            // The error that led here is the one to report.
            let _ = self.tail.end_short();
        }
    }
}

/// Something that messages are for: a file, or the log they are held against.
pub(super) trait LogChannels {
    /// Adds a channel for messages of the `schema` (name, encoding, data) and returns its identifier.
    fn channel(&mut self, topic: &str, schema: (&str, &str, &[u8]), encoding: &str) -> Result<u16, LogError>;
}

impl LogChannels for LogFile {
    fn channel(&mut self, topic: &str, schema: (&str, &str, &[u8]), encoding: &str) -> Result<u16, LogError> {
        let (name, schema_encoding, data) = schema;
        let channel = Channel {
            topic: topic.to_string(),
            schema: (name.to_string(), schema_encoding.to_string(), data.to_vec()),
            encoding: encoding.to_string(),
        };
        let identifier = add_channel(&mut self.writer, &channel).map_err(|error| write_error(&self.path, error))?;
        self.channels.push(channel);
        Ok(identifier)
    }
}

impl Provisional {
    fn new(channels: &[Channel]) -> Result<Self, McapError> {
        let written = Pending::default();
        let sink = Sink { pending: written.clone(), position: 0 };
        let mut writer = write_options().create(sink)?;
        for channel in channels {
            add_channel(&mut writer, channel)?;
        }
        // The channels are in the final part already; only what follows is wanted.
        writer.flush()?;
        written.take();
        Ok(Provisional { writer, written, messages: 0 })
    }
}

fn add_channel<W: Write + Seek>(writer: &mut Writer<W>, channel: &Channel) -> Result<u16, McapError> {
    let (name, encoding, data) = &channel.schema;
    let schema = writer.add_schema(name, encoding, data)?;
    writer.add_channel(schema, &channel.topic, &channel.encoding, &BTreeMap::new())
}

fn write_options() -> WriteOptions {
    WriteOptions::new()
        .library(concat!("catena ", env!("CARGO_PKG_VERSION")))
        // Chunks end where batches end; no threads, because their number must not change the bytes.
        .chunk_size(None)
        .compression_threads(0)
        // Half of the work of zstd for 13 % more bytes (benches/README.md).
        .compression(Some(Compression::Lz4))
        .compression_level(0)
        // A chunk is then written in one piece, with its final header.
        .disable_seeking(true)
}

fn write_error(path: &Path, error: McapError) -> LogError {
    let reason = match error {
        McapError::Io(reason) => reason,
        other => io::Error::other(other),
    };
    LogError::Write { path: path.to_path_buf(), reason }
}

/// Bytes on their way from a writer to the file.
#[derive(Clone, Default)]
struct Pending(Arc<Mutex<Vec<u8>>>);

impl Pending {
    fn take(&self) -> Vec<u8> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Where a writer writes: into memory, in order.
struct Sink {
    pending: Pending,
    position: u64,
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.pending.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        self.position += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Sink {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.position),
            _ => Err(io::Error::new(io::ErrorKind::Unsupported, "a log is written from beginning to end")),
        }
    }
}

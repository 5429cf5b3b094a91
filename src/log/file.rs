//! The MCAP file under the log: batches of messages, and a file that is readable whenever the process is killed.
//!
//! Messages are collected in memory and written as one compressed chunk whenever the next would not fit into
//! [`CHUNK_SIZE`]. Where chunks end depends on the messages alone, which makes equal runs give equal files. A run that
//! is slow would then leave little behind when it is killed; so about every second the batch that is still open is
//! written after the last chunk as a chunk of its own, which is overwritten when the batch is complete:
//!
//! ```text
//!     magic  header  metadata  attachment | chunk | chunk | … | chunk of the open batch     a running simulation
//!     magic  header  metadata  attachment | chunk | chunk | … | chunk | summary  magic      a finished file
//! ```
//!
//! Only regular files have such a provisional end; into pipes and devices nothing is written that is not final.

use super::batch::Batch;
use mcap::records::Metadata;
use mcap::{Attachment, McapError, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Cursor, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Largest uncompressed size of a chunk of several messages.
const CHUNK_SIZE: usize = 1 << 20;

/// How much of a run may be lost when the process is killed.
pub(super) const PROVISIONAL_INTERVAL: Duration = Duration::from_secs(1);

/// Why the log could not be written.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file could not be created; nothing was changed.
    #[error("cannot create {}: {reason}", path.display())]
    Create { path: PathBuf, reason: io::Error },
    /// Writing failed: a full disk, a closed pipe.
    #[error("cannot write {}: {reason}", path.display())]
    Write { path: PathBuf, reason: io::Error },
}

/// A channel of the log, in the order of creation: topic, schema (name, encoding, data), message encoding.
struct Channel {
    topic: String,
    schema: (String, String, Vec<u8>),
    encoding: String,
}

/// An MCAP file being written.
pub(super) struct LogFile {
    path: PathBuf,
    file: Arc<File>,
    is_regular: bool,
    writer: Writer<BufWriter<Sink>>,
    channels: Vec<Channel>,
    /// The messages that are in no final chunk yet.
    batch: Batch,
    saved: Instant,
    saved_messages: usize,
}

impl LogFile {
    /// Creates the file, or empties it.
    ///
    /// # Errors
    /// [`LogError::Create`] if that is not possible, [`LogError::Write`] if its first bytes cannot be written.
    pub(super) fn create(path: &Path) -> Result<Self, LogError> {
        let create = || -> io::Result<(File, bool)> {
            let file = File::create(path)?;
            let is_regular = file.metadata()?.is_file();
            Ok((file, is_regular))
        };
        let (file, is_regular) = create().map_err(|reason| LogError::Create { path: path.to_path_buf(), reason })?;
        let file = Arc::new(file);
        let sink = BufWriter::new(Sink { file: file.clone(), position: 0 });
        let writer = write_options().create(sink).map_err(|error| write_error(path, error))?;
        Ok(LogFile {
            path: path.to_path_buf(),
            file,
            is_regular,
            writer,
            channels: Vec::new(),
            batch: Batch::default(),
            saved: Instant::now(),
            saved_messages: 0,
        })
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

    /// Adds a channel for messages of the `schema` (name, encoding, data) and returns its identifier.
    pub(super) fn channel(
        &mut self,
        topic: &str,
        schema: (&str, &str, &[u8]),
        encoding: &str,
    ) -> Result<u16, LogError> {
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
    pub(super) fn close_batch(&mut self) -> Result<(), LogError> {
        self.batch
            .write_to(&mut self.writer)
            .and_then(|()| self.writer.flush())
            .map_err(|error| write_error(&self.path, error))?;
        self.batch.clear();
        self.saved = Instant::now();
        self.saved_messages = 0;
        Ok(())
    }

    /// Writes the open batch as a provisional chunk, if it has waited long enough, and leaves the file where it was.
    pub(super) fn save_if_due(&mut self) -> Result<(), LogError> {
        let has_news = self.batch.count() > self.saved_messages;
        if self.is_regular && has_news && self.saved.elapsed() >= PROVISIONAL_INTERVAL {
            self.save_chunk().map_err(|error| write_error(&self.path, error))?;
            self.saved_messages = self.batch.count();
            self.saved = Instant::now();
        }
        Ok(())
    }

    fn save_chunk(&self) -> Result<(), McapError> {
        let header = write_options().create(Cursor::new(Vec::new()))?.into_inner().into_inner();
        let mut writer = write_options().create(Cursor::new(Vec::new()))?;
        for channel in &self.channels {
            add_channel(&mut writer, channel)?;
        }
        self.batch.write_to(&mut writer)?;
        writer.flush()?;
        let chunk = writer.into_inner().into_inner();
        let mut file = &*self.file;
        let end = file.stream_position()?;
        file.write_all(&chunk[header.len()..])?;
        file.seek(SeekFrom::Start(end))?;
        Ok(())
    }

    /// Completes the file: everything collected, the summary, and nothing provisional after it.
    ///
    /// # Errors
    /// [`LogError::Write`], as for every message.
    pub(super) fn finish(mut self) -> Result<(), LogError> {
        if self.batch.count() > 0 {
            self.close_batch()?;
        }
        let path = self.path;
        let mut writer = self.writer;
        writer.finish().map_err(|error| write_error(&path, error))?;
        let ended = writer.into_inner().into_inner().map_err(|error| error.into_error()).and_then(|sink| {
            match self.is_regular {
                true => self.file.set_len(sink.position),
                false => Ok(()),
            }
        });
        ended.map_err(|reason| LogError::Write { path, reason })
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
        .compression_level(1)
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

/// Where the bytes go, in order; it knows its position without asking, because pipes have none.
struct Sink {
    file: Arc<File>,
    position: u64,
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = (&*self.file).write(bytes)?;
        self.position += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        (&*self.file).flush()
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

//! Reads a log from its beginning to its end, or to where it was cut off.
//!
//! Records come one after the other and little of the file is in memory at any time. A chunk is shown only if its
//! checksum is right. Where the file ends inside a chunk there is no telling, since the checksum is of all of it: its whole
//! records are shown, and how many messages that were is said.

use super::output::{END, FINISHED, OUTCOME};
use mcap::records::{Record, op};
use mcap::sans_io::{
    LinearReadEvent, LinearReader, LinearReaderOptions, SummaryReadEvent, SummaryReader, SummaryReaderOptions,
};
use mcap::{McapError, parse_record};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Most bytes that are read at once.
const BLOCK: usize = 1 << 18;

/// Length of the opcode and of the length before every record.
const RECORD_HEADER: usize = 9;

/// Why a log could not be read at all.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be opened or read.
    #[error("cannot read {}: {reason}", path.display())]
    Io { path: PathBuf, reason: io::Error },
    /// It does not start like an MCAP file.
    #[error("{}: not an MCAP log: {reason}", path.display())]
    NotALog { path: PathBuf, reason: String },
    /// A message is not what its schema says.
    #[error("{}: topic {topic} at t = {time} s: {reason}", path.display())]
    Message { path: PathBuf, topic: String, time: f64, reason: String },
}

/// How much of a log there is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Completeness {
    /// All of it.
    Complete,
    /// It ends in the middle: the run was killed, or it is still being written.
    Cut {
        /// Length of the file in bytes.
        bytes: u64,
        /// The last so many messages are of a chunk that is not whole, so that they could not be checked.
        unchecked: u64,
    },
    /// From some place on it cannot be read.
    Damaged {
        /// What is wrong.
        reason: String,
    },
}

/// A channel of a log.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogChannel {
    /// Its topic.
    pub topic: String,
    /// Name of the schema, empty if there is none.
    pub schema: String,
    /// How messages are encoded: `cdr`, `protobuf`.
    pub encoding: String,
}

/// What is in a log, in its order.
pub enum Item<'i> {
    /// The program that wrote it.
    Library(&'i str),
    /// A channel that messages may follow of.
    Channel(&'i LogChannel),
    /// A message; `time` in nanoseconds.
    Message { channel: &'i LogChannel, time: u64, data: &'i [u8] },
    /// A metadata record.
    Metadata { name: &'i str, entries: &'i BTreeMap<String, String> },
    /// An attachment.
    Attachment { name: &'i str, media_type: &'i str, data: &'i [u8] },
}

/// Shows a log to `visit`, item by item, until it breaks off, the log ends, or cannot be read any further; `None` if it
/// was broken off.
///
/// # Errors
/// [`ReadError`] if it is not a log at all.
pub fn read_log(
    path: &Path,
    mut visit: impl FnMut(Item<'_>) -> ControlFlow<()>,
) -> Result<Option<Completeness>, ReadError> {
    let io_error = |reason| ReadError::Io { path: path.to_path_buf(), reason };
    let mut file = File::open(path).map_err(io_error)?;
    let mut reader = LinearReader::new_with_options(LinearReaderOptions::default().with_emit_chunks(true));
    let mut records = Records { schemas: HashMap::new(), channels: HashMap::new(), messages: 0, visit: &mut visit };
    // The last bytes, and how many of them are of records that were shown: in the end the rest is of one that is not whole.
    let (mut recent, mut shown) = (Vec::new(), mcap::MAGIC.len());
    let (mut bytes, mut seen) = (0_u64, false);
    while let Some(event) = reader.next_event() {
        let flow = match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                // What a damaged length asks for is not allocated in advance.
                let block = reader.insert(wanted.clamp(1 << 12, BLOCK));
                let count = file.read(block).map_err(io_error)?;
                recent.extend_from_slice(&block[..count]);
                let past = shown.min(recent.len());
                recent.drain(..past);
                shown -= past;
                reader.notify_read(count);
                bytes += count as u64;
                continue;
            }
            Ok(LinearReadEvent::Record { opcode, data }) => {
                shown += RECORD_HEADER + data.len();
                if opcode == op::CHUNK { records.chunk(data.len() as u64, data) } else { records.show(opcode, data) }
            }
            Err(McapError::UnexpectedEof) if seen => {
                let unchecked = records.torn_chunk(&recent[shown.min(recent.len())..]);
                return Ok(unchecked.map(|unchecked| Completeness::Cut { bytes, unchecked }));
            }
            Err(error) if seen => Err(error),
            Err(error) => {
                return Err(ReadError::NotALog { path: path.to_path_buf(), reason: error.to_string() });
            }
        };
        seen = true;
        match flow {
            Ok(ControlFlow::Continue(())) => {}
            Ok(ControlFlow::Break(())) => return Ok(None),
            Err(error) => return Ok(Some(Completeness::Damaged { reason: error.to_string() })),
        }
    }
    Ok(Some(Completeness::Complete))
}

/// Shows records to `visit`.
struct Records<'v, V> {
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, LogChannel>,
    /// Messages up to now.
    messages: u64,
    visit: &'v mut V,
}

impl<V: FnMut(Item<'_>) -> ControlFlow<()>> Records<'_, V> {
    /// Shows a record that is no chunk.
    fn show(&mut self, opcode: u8, data: &[u8]) -> Result<ControlFlow<()>, McapError> {
        Ok(match parse_record(opcode, data)? {
            Record::Header(header) => (self.visit)(Item::Library(&header.library)),
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
                ControlFlow::Continue(())
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let known = LogChannel { topic: channel.topic, schema, encoding: channel.message_encoding };
                let is_new = self.channels.get(&channel.id) != Some(&known);
                let known = self.channels.entry(channel.id).insert_entry(known);
                if is_new { (self.visit)(Item::Channel(known.get())) } else { ControlFlow::Continue(()) }
            }
            Record::Message { header, data } => {
                let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
                let channel = self.channels.get(&header.channel_id).ok_or(unknown)?;
                self.messages += 1;
                (self.visit)(Item::Message { channel, time: header.log_time, data: &data })
            }
            Record::Metadata(metadata) => {
                (self.visit)(Item::Metadata { name: &metadata.name, entries: &metadata.metadata })
            }
            Record::Attachment { header, data, .. } => {
                (self.visit)(Item::Attachment { name: &header.name, media_type: &header.media_type, data: &data })
            }
            _ => ControlFlow::Continue(()),
        })
    }

    /// Shows what is in a chunk, if its checksum is right.
    fn chunk(&mut self, length: u64, data: &[u8]) -> Result<ControlFlow<()>, McapError> {
        self.inside(length, data, LinearReaderOptions::default().with_prevalidate_chunk_crcs(true))
    }

    /// Shows the whole records of a chunk that begins with `bytes`, if they are of a chunk. Returns how many messages they
    /// have, or nothing if that was broken off.
    fn torn_chunk(&mut self, bytes: &[u8]) -> Option<u64> {
        let before = self.messages;
        if let Some((&[op::CHUNK, ref length @ ..], data)) = bytes.split_first_chunk::<RECORD_HEADER>() {
            // It ends with an error: the chunk does not end.
            let flow = self.inside(u64::from_le_bytes(*length), data, LinearReaderOptions::default());
            if let Ok(ControlFlow::Break(())) = flow {
                return None;
            }
        }
        Some(self.messages - before)
    }

    /// Shows the records inside a chunk of this length, of which there are these bytes.
    fn inside(&mut self, length: u64, data: &[u8], options: LinearReaderOptions) -> Result<ControlFlow<()>, McapError> {
        let mut reader = LinearReader::new_with_options(options.with_skip_start_magic(true).with_skip_end_magic(true));
        let length = length.to_le_bytes();
        let mut parts = [&[op::CHUNK][..], &length, data].into_iter();
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(_) => {
                    let part = parts.next().unwrap_or_default();
                    reader.insert(part.len()).copy_from_slice(part);
                    reader.notify_read(part.len());
                }
                LinearReadEvent::Record { opcode, data } => {
                    if self.show(opcode, data)?.is_break() {
                        return Ok(ControlFlow::Break(()));
                    }
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    }
}

/// Whether a file is a log of ours that lacks its end or says that its run did not finish.
pub(super) fn is_unfinished(path: &Path) -> bool {
    let mut library = String::new();
    let started = read_log(path, |item| {
        if let Item::Library(name) = item {
            library = name.to_string();
        }
        ControlFlow::Break(())
    });
    if started.is_err() || !library.starts_with("catena ") {
        return false;
    }
    match last_words(path) {
        // A log of an earlier version, which did not say how it ended, may be dear to its owner.
        Ok(Some(words)) => words.is_some_and(|words| words.get(OUTCOME).is_none_or(|outcome| outcome != FINISHED)),
        Ok(None) | Err(_) => true,
    }
}

/// What the log says about its end, read from the summary; `None` without a summary, `Some(None)` if it says nothing.
#[allow(clippy::option_option, reason = "there are three cases")]
fn last_words(path: &Path) -> Result<Option<Option<BTreeMap<String, String>>>, McapError> {
    let mut file = File::open(path)?;
    let size = file.metadata()?.len();
    let mut reader = SummaryReader::new_with_options(SummaryReaderOptions::default().with_file_size(size));
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(wanted) => {
                let count = file.read(reader.insert(wanted))?;
                reader.notify_read(count);
            }
            SummaryReadEvent::SeekRequest(to) => {
                let position = file.seek(to)?;
                reader.notify_seeked(position);
            }
        }
    }
    let Some(summary) = reader.finish() else { return Ok(None) };
    let Some(index) = summary.metadata_indexes.iter().rev().find(|index| index.name == END) else {
        return Ok(Some(None));
    };
    file.seek(SeekFrom::Start(index.offset))?;
    let mut record = Vec::new();
    file.take(index.length).read_to_end(&mut record)?;
    match record.split_at_checked(9).map(|(head, body)| parse_record(head[0], body)) {
        Some(Ok(Record::Metadata(metadata))) => Ok(Some(Some(metadata.metadata))),
        _ => Ok(Some(None)),
    }
}

//! The records of an MCAP file from its beginning to its end, or to where it was cut off.
//!
//! They come one after the other and little of the file is in memory at any time. A chunk is shown only if its
//! checksum is right. Where the file ends inside a chunk there is no telling, since the checksum is of all of it: its whole
//! records are shown, and how many messages that were is said.

use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};
use std::fs::File;
use std::io::{self, Read};
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

impl Completeness {
    /// Where the log breaks off, in words, if it does.
    pub fn broken_off(&self) -> Option<String> {
        match self {
            Completeness::Complete => None,
            Completeness::Cut { bytes, unchecked: 0 } => Some(format!("it ends in the middle, after {bytes} bytes")),
            Completeness::Cut { bytes, unchecked } => Some(format!(
                "it ends in the middle, after {bytes} bytes, and its last {unchecked} messages lack their checksum"
            )),
            Completeness::Damaged { reason } => Some(format!("from some place on it cannot be read: {reason}")),
        }
    }
}

/// Goes on with the next record, breaks off, or says what is wrong with this one.
pub(super) type Seen = Result<ControlFlow<()>, String>;

/// Shows the records of a file to `visit`, those in chunks too, until it breaks off, the file ends, or it cannot be read any
/// further; `None` if it was broken off.
///
/// # Errors
/// [`ReadError`] if it is no such file.
pub(super) fn read_records(
    path: &Path,
    visit: &mut dyn FnMut(Record<'_>) -> Seen,
) -> Result<Option<Completeness>, ReadError> {
    let io_error = |reason| ReadError::Io { path: path.to_path_buf(), reason };
    let mut file = File::open(path).map_err(io_error)?;
    let mut reader = LinearReader::new_with_options(LinearReaderOptions::default().with_emit_chunks(true));
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
            Ok(LinearReadEvent::Record { opcode: op::CHUNK, data }) => {
                shown += RECORD_HEADER + data.len();
                chunk(data.len() as u64, data, true, visit)
            }
            Ok(LinearReadEvent::Record { opcode, data }) => {
                shown += RECORD_HEADER + data.len();
                show(opcode, data, visit)
            }
            Err(McapError::UnexpectedEof) if seen => {
                let unchecked = torn_chunk(&recent[shown.min(recent.len())..], visit);
                return Ok(unchecked.map(|unchecked| Completeness::Cut { bytes, unchecked }));
            }
            Err(error) if seen => Err(error.to_string()),
            Err(error) => {
                return Err(ReadError::NotALog { path: path.to_path_buf(), reason: error.to_string() });
            }
        };
        seen = true;
        match flow {
            Ok(ControlFlow::Continue(())) => {}
            Ok(ControlFlow::Break(())) => return Ok(None),
            Err(reason) => return Ok(Some(Completeness::Damaged { reason })),
        }
    }
    Ok(Some(Completeness::Complete))
}

fn show(opcode: u8, data: &[u8], visit: &mut dyn FnMut(Record<'_>) -> Seen) -> Seen {
    visit(parse_record(opcode, data).map_err(|error| error.to_string())?)
}

/// Shows the records inside a chunk of this length, of which there are these bytes; those of a whole chunk if its checksum
/// is right.
fn chunk(length: u64, data: &[u8], is_whole: bool, visit: &mut dyn FnMut(Record<'_>) -> Seen) -> Seen {
    let options = LinearReaderOptions::default().with_skip_start_magic(true).with_skip_end_magic(true);
    let mut reader = LinearReader::new_with_options(options.with_prevalidate_chunk_crcs(is_whole));
    let length = length.to_le_bytes();
    let mut parts = [&[op::CHUNK][..], &length, data].into_iter();
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| error.to_string())? {
            LinearReadEvent::ReadRequest(_) => {
                let part = parts.next().unwrap_or_default();
                reader.insert(part.len()).copy_from_slice(part);
                reader.notify_read(part.len());
            }
            LinearReadEvent::Record { opcode, data } => {
                if show(opcode, data, visit)?.is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
        }
    }
    Ok(ControlFlow::Continue(()))
}

/// Shows the whole records of a chunk that begins with `bytes`, if they are of a chunk. Returns how many messages they
/// have, or nothing if that was broken off.
fn torn_chunk(bytes: &[u8], visit: &mut dyn FnMut(Record<'_>) -> Seen) -> Option<u64> {
    let mut messages = 0;
    if let Some((&[op::CHUNK, ref length @ ..], data)) = bytes.split_first_chunk::<RECORD_HEADER>() {
        let mut count = |record: Record<'_>| {
            let is_message = matches!(record, Record::Message { .. });
            let flow = visit(record)?;
            messages += u64::from(is_message);
            Ok(flow)
        };
        // It ends with an error: the chunk does not end.
        if let Ok(ControlFlow::Break(())) = chunk(u64::from_le_bytes(*length), data, false, &mut count) {
            return None;
        }
    }
    Some(messages)
}

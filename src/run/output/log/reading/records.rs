//! The records of an MCAP file from its beginning to its end, or to where it was cut off.
//!
//! They come one after the other, and little of the file is in memory at any time. A chunk is shown only if its checksum is right. An unreadable
//! chunk is passed over, because its length tells where the next record is, and so is any other record. If the file ends inside a chunk, its checksum
//! cannot be compared, since it covers the whole chunk. The whole records of the chunk are shown then, and the number of their messages is reported.
//! The checksum of the file comes last, when everything has been shown.

use crate::mechanism::ground::words::counted;
use crate::output::log::encoding::names::start_of;
use crate::output::log::encoding::time::seconds;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};
use serde::Serialize;
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Most bytes that are read at once.
const BLOCK: usize = 1 << 18;

/// Length of the opcode and of the length before every record.
const RECORD_HEADER: usize = 9;

/// A length beyond this is damaged, and with others there is no overflow.
const LONGEST_RECORD: usize = usize::MAX >> 8;

/// The end of reading at an unreadable record, though the file goes on.
pub(crate) const FROM_SOME_PLACE: &str = "from some place on it cannot be read";

/// Chunks that say that there is more in them are not unpacked: there may be as much in memory.
const LARGEST_CHUNK: usize = 1 << 30;

/// Why a log could not be read at all.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be opened or read.
    #[error("cannot read {}: {reason}", path.display())]
    Io { path: PathBuf, reason: io::Error },
    /// It does not start like an MCAP file.
    #[error("{}: not an MCAP log: {reason}", path.display())]
    NotALog { path: PathBuf, reason: String },
}

/// The readable part of a log; the default is a complete log.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Completeness {
    /// Whether its content differs from the written one: chunks are lost, or it cannot be read to its end.
    pub damaged: bool,
    /// Chunks that cannot be read although others follow.
    pub lost_chunks: Option<LostChunks>,
    /// Other records that cannot be read although others follow: attachments and metadata.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_records: Option<LostRecords>,
    /// The place at which it breaks off, if it does: the run was killed, it is still being written, or the rest cannot be read.
    pub broken_off: Option<String>,
}

/// Chunks that cannot be read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LostChunks {
    /// How many.
    pub count: usize,
    /// Time of the last message before the first of them (s); zero without one.
    pub after: f64,
    /// Time of the first message after the last of them (s).
    pub before: Option<f64>,
    /// The defect of the first.
    pub reason: String,
}

/// Records outside of chunks that cannot be read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LostRecords {
    /// How many.
    pub count: usize,
    /// The defect of the first.
    pub reason: String,
}

impl fmt::Display for LostRecords {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} cannot be read: {}", counted(self.count, "record", "records"), self.reason)
    }
}

impl Completeness {
    /// Whether all of it is there.
    pub fn is_complete(&self) -> bool {
        self.missing().is_none()
    }

    /// The missing parts, in words, if it is incomplete.
    pub fn missing(&self) -> Option<String> {
        let lost = self.lost_chunks.as_ref().map(ToString::to_string);
        let records = self.lost_records.as_ref().map(ToString::to_string);
        let words: Vec<String> = lost.into_iter().chain(records).chain(self.broken_off.clone()).collect();
        let kind = if self.damaged { "DAMAGED" } else { "TRUNCATED" };
        (!words.is_empty()).then(|| format!("{kind}: {}", words.join("; ")))
    }
}

impl fmt::Display for LostChunks {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LostChunks { count, after, before, reason } = self;
        write!(out, "{}", counted(*count, "chunk", "chunks"))?;
        match before {
            Some(before) => write!(out, " between t = {after} s and t = {before} s")?,
            None => write!(out, " after t = {after} s")?,
        }
        write!(out, " cannot be read: {reason}")
    }
}

/// An item of a file.
pub(crate) enum Found<'f> {
    /// A record that can be read.
    Record(Record<'f>),
    /// A chunk that cannot, and why.
    LostChunk(&'f str),
}

/// The answer of a visitor: it goes on, breaks off, or names the defect of this record.
pub(crate) type Seen = Result<ControlFlow<()>, String>;

type Visit<'v> = dyn FnMut(Found<'_>) -> Seen + 'v;

/// Shows the content of a file to `visit`, the records in chunks too, until it breaks off, the file ends, or it cannot be read any further; `None` if
/// it was broken off.
///
/// # Errors
/// [`ReadError`] if it is no such file.
pub(crate) fn read_records(path: &Path, visit: &mut Visit<'_>) -> Result<Option<Completeness>, ReadError> {
    let io_error = |reason| ReadError::Io { path: path.to_path_buf(), reason };
    let mut file = File::open(path).map_err(io_error)?;
    let options = LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(LONGEST_RECORD);
    let options = options.with_validate_data_section_crc(true).with_validate_summary_section_crc(true);
    let mut reader = LinearReader::new_with_options(options.with_check_finishes_after_end_magic(true));
    // The last bytes, and how many of them are of records that were shown: in the end the rest is of one that is not whole.
    let (mut recent, mut shown) = (Vec::new(), mcap::MAGIC.len());
    let (mut bytes, mut seen) = (0_u64, false);
    let (mut damaged, mut broken_off) = (false, None);
    let (mut time, mut lost, mut lost_records) = (0.0, None::<LostChunks>, None::<LostRecords>);
    let mut start = 0;
    let mut timed = |found: Found<'_>| {
        match &found {
            Found::Record(Record::Metadata(metadata)) => start = start_of(metadata).unwrap_or(start),
            Found::Record(Record::Message { header, .. }) => {
                time = seconds(header.log_time.saturating_sub(start));
                if let Some(lost) = &mut lost {
                    lost.before.get_or_insert(time);
                }
            }
            Found::Record(_) => {}
            Found::LostChunk(reason) => {
                let reason = reason.to_string();
                let lost = lost.get_or_insert(LostChunks { count: 0, after: time, before: None, reason });
                (lost.count, lost.before) = (lost.count + 1, None);
            }
        }
        visit(found)
    };
    while let Some(event) = reader.next_event() {
        let flow = match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                // The length of a damaged record is not allocated in advance.
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
                chunk(data.len() as u64, data, true, &mut timed).or_else(|reason| timed(Found::LostChunk(&reason)))
            }
            Ok(LinearReadEvent::Record { opcode, data }) => {
                shown += RECORD_HEADER + data.len();
                match parse_record(opcode, data) {
                    // The index of a chunk is not used, so a damaged one does no harm.
                    _ if opcode == op::MESSAGE_INDEX => Ok(ControlFlow::Continue(())),
                    Ok(record) => timed(Found::Record(record)),
                    Err(error) => {
                        let reason = error.to_string();
                        lost_records.get_or_insert(LostRecords { count: 0, reason }).count += 1;
                        Ok(ControlFlow::Continue(()))
                    }
                }
            }
            Err(McapError::UnexpectedEof) if seen => {
                let Some(unchecked) = torn_chunk(&recent[shown.min(recent.len())..], &mut timed) else {
                    return Ok(None);
                };
                let lacking = match unchecked {
                    0 => String::new(),
                    _ => format!(", and its last {unchecked} messages lack their checksum"),
                };
                broken_off = Some(format!("it ends in the middle, after {bytes} bytes{lacking}"));
                break;
            }
            // The lost parts are reported already.
            Err(McapError::BadDataCrc { .. }) if lost.is_some() || lost_records.is_some() => break,
            Err(error) if seen => {
                damaged = true;
                broken_off = Some(match error {
                    McapError::BadDataCrc { .. } | McapError::BadSummaryCrc { .. } => {
                        "its checksum says that something in it is not what was written".to_string()
                    }
                    McapError::BytesAfterEndMagic => "behind its end there are more bytes".to_string(),
                    error => format!("{FROM_SOME_PLACE}: {error}"),
                });
                break;
            }
            Err(error) => {
                return Err(ReadError::NotALog { path: path.to_path_buf(), reason: error.to_string() });
            }
        };
        seen = true;
        match flow {
            Ok(ControlFlow::Continue(())) => {}
            Ok(ControlFlow::Break(())) => return Ok(None),
            Err(reason) => {
                damaged = true;
                broken_off = Some(format!("{FROM_SOME_PLACE}: {reason}"));
                break;
            }
        }
    }
    damaged |= lost.is_some() || lost_records.is_some();
    Ok(Some(Completeness { damaged, lost_chunks: lost, lost_records, broken_off }))
}

fn show(opcode: u8, data: &[u8], visit: &mut Visit<'_>) -> Seen {
    visit(Found::Record(parse_record(opcode, data).map_err(|error| error.to_string())?))
}

/// Shows the records inside a chunk of this length, of which these bytes were read. The records of a whole chunk are shown only if its checksum is
/// right.
fn chunk(length: u64, data: &[u8], is_whole: bool, visit: &mut Visit<'_>) -> Seen {
    let options = LinearReaderOptions::default().with_skip_start_magic(true).with_skip_end_magic(true);
    let options = options.with_prevalidate_chunk_crcs(is_whole).with_record_length_limit(LARGEST_CHUNK);
    let mut reader = LinearReader::new_with_options(options);
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

/// Shows the whole records of a chunk that begins with `bytes`, if they are of a chunk. Returns how many messages they have, or `None` if that was
/// broken off.
fn torn_chunk(bytes: &[u8], visit: &mut Visit<'_>) -> Option<u64> {
    let mut messages = 0;
    if let Some((&[op::CHUNK, ref length @ ..], data)) = bytes.split_first_chunk::<RECORD_HEADER>() {
        let mut count = |found: Found<'_>| {
            let is_message = matches!(found, Found::Record(Record::Message { .. }));
            let flow = visit(found)?;
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

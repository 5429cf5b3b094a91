//! A complete log of all that can be read in one that is not: for viewers that need the index at the end of the file.

use crate::output::log::encoding::names::LIBRARY_VERSION;
use crate::output::log::reading::reader::no_channel;
use crate::output::log::reading::records::{Found, ReadError, read_records};
use mcap::records::{MessageHeader, Metadata, Record};
use mcap::{Attachment, McapError, WriteOptions, Writer};
use std::collections::{BTreeMap, HashMap};
use std::io::{Seek, Write};
use std::ops::ControlFlow;
use std::path::Path;

/// Largest size of a chunk.
const CHUNK_SIZE: u64 = 1 << 18;

/// Why a log could not be recovered.
#[derive(Debug, thiserror::Error)]
pub enum RecoveryError {
    /// It could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The new one could not be written.
    #[error(transparent)]
    Write(#[from] McapError),
}

/// The metadata record of a log that was made of one of which something is missing, and its entry that says what.
pub const RECOVERY: &str = "recovery";
/// See [`RECOVERY`].
pub const MISSING: &str = "missing";

/// Writes everything of a log, as far as it can be read, as a complete one, which names its missing parts ([`RECOVERY`]); returns the number of its
/// messages.
///
/// # Errors
/// [`RecoveryError`].
pub fn recover(log: &Path, out: &mut (impl Write + Seek)) -> Result<u64, RecoveryError> {
    let options = WriteOptions::new().library(LIBRARY_VERSION).compression(None).chunk_size(Some(CHUNK_SIZE));
    let mut copy =
        Copy { writer: options.create(out)?, schemas: HashMap::new(), channels: HashMap::new(), messages: 0 };
    let mut failure = None;
    let completeness = read_records(log, &mut |found| {
        let Found::Record(record) = found else { return Ok(ControlFlow::Continue(())) };
        match copy.record(record) {
            Ok(seen) => seen.map(ControlFlow::Continue),
            Err(error) => {
                failure = Some(error);
                Ok(ControlFlow::Break(()))
            }
        }
    })?;
    if let Some(error) = failure {
        return Err(error.into());
    }
    if let Some(missing) = completeness.and_then(|completeness| completeness.missing()) {
        let metadata = BTreeMap::from([(MISSING.to_string(), missing)]);
        copy.writer.write_metadata(&Metadata { name: RECOVERY.to_string(), metadata })?;
    }
    copy.writer.finish()?;
    Ok(copy.messages)
}

struct Copy<W: Write + Seek> {
    writer: Writer<W>,
    /// The identifiers in the copy by the identifiers in the log.
    schemas: HashMap<u16, u16>,
    channels: HashMap<u16, u16>,
    messages: u64,
}

impl<W: Write + Seek> Copy<W> {
    /// Copies a record, or names its defect.
    fn record(&mut self, record: Record<'_>) -> Result<Result<(), String>, McapError> {
        match record {
            Record::Schema { header, data } => {
                let schema = self.writer.add_schema(&header.name, &header.encoding, &data)?;
                self.schemas.insert(header.id, schema);
            }
            Record::Channel(channel) => {
                // Zero is a channel without a schema.
                let schema = self.schemas.get(&channel.schema_id).copied().unwrap_or(0);
                let encoding = &channel.message_encoding;
                let copied = self.writer.add_channel(schema, &channel.topic, encoding, &channel.metadata)?;
                self.channels.insert(channel.id, copied);
            }
            Record::Message { header, data } => {
                let Some(&channel_id) = self.channels.get(&header.channel_id) else {
                    return Ok(Err(no_channel(header.channel_id)));
                };
                self.writer.write_to_known_channel(&MessageHeader { channel_id, ..header }, &data)?;
                self.messages += 1;
            }
            Record::Metadata(metadata) => self.writer.write_metadata(&metadata)?,
            Record::Attachment { header, data, .. } => self.writer.attach(&Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                media_type: header.media_type,
                name: header.name,
                data,
            })?,
            _ => {}
        }
        Ok(Ok(()))
    }
}

//! The MCAP container: where its records are, so that readers find them.
//!
//! ```text
//!     magic  header | metadata  attachments | chunk  message indexes | chunk  message indexes | … | metadata   data section
//!     data end | schemas  channels  statistics  chunk, attachment and metadata indexes | summary offsets       summary section
//!     footer  magic
//! ```
//!
//! The `mcap` crate encodes the content of records. This file decides their order, offsets, counts and checksums. The first chunk begins with all
//! schemas and channels. The profile is `ros2`: all messages are CDR, and channels say in their metadata how they are offered, as channels of bags
//! do.
//!
//! The crate's own writer takes a message in seven pieces, each through three layers with a checksum in two of them. This costs a third of a sample,
//! and it cannot take a chunk that is encoded already. Because of this it is not used (doc/decisions/020-log-container.md). Its readers, and the
//! readers of Python, compare these files with the format in `tests/program/log_readback/`. Source: MCAP format specification (mcap.dev/spec).

use crate::output::log::encoding::definitions::Definition;
use crate::output::log::encoding::durability::Durability;
use crate::output::log::storage::batch::{Batch, Entry, RECORD_HEADER};
use crate::output::log::storage::compression::Packing;
use binrw::{BinResult, BinWrite, Endian};
use crc32fast::Hasher;
use mcap::MAGIC;
use mcap::records::{
    AttachmentHeader, AttachmentIndex, Channel, ChunkHeader, ChunkIndex, DataEnd, Footer, Header, Metadata,
    MetadataIndex, SchemaHeader, Statistics, SummaryOffset, op,
};
use std::collections::BTreeMap;
use std::io::Cursor;

/// How schemas and messages are encoded.
const SCHEMA_ENCODING: &str = "ros2msg";
const MESSAGE_ENCODING: &str = "cdr";

/// The profile that readers may expect: topics, types and encodings of ROS 2.
const PROFILE: &str = "ros2";

/// Adds a record of this content, and `rest` after it; returns the length of the record.
fn record<R>(out: &mut Vec<u8>, opcode: u8, content: &R, rest: &[&[u8]]) -> BinResult<u64>
where
    R: for<'a> BinWrite<Args<'a> = ()>,
{
    let start = out.len();
    out.push(opcode);
    out.extend_from_slice(&[0; 8]);
    let mut cursor = Cursor::new(&mut *out);
    cursor.set_position((start + RECORD_HEADER) as u64);
    content.write_options(&mut cursor, Endian::Little, ())?;
    rest.iter().for_each(|piece| out.extend_from_slice(piece));
    let length = (out.len() - start) as u64;
    set_length(&mut out[start..], length);
    Ok(length)
}

/// Puts the length of a whole record into it.
fn set_length(record: &mut [u8], length: u64) {
    record[1..RECORD_HEADER].copy_from_slice(&(length - RECORD_HEADER as u64).to_le_bytes());
}

/// An MCAP file as far as it has been encoded.
#[derive(Clone)]
pub(crate) struct Container {
    /// Bytes that have not been taken yet.
    out: Vec<u8>,
    /// Length of the bytes that have been taken.
    taken: u64,
    checksum: Hasher,
    schema_numbers: BTreeMap<&'static str, u16>,
    /// Records for the summary.
    schemas: Vec<u8>,
    channels: Vec<u8>,
    chunk_indexes: Vec<u8>,
    attachment_indexes: Vec<u8>,
    metadata_indexes: Vec<u8>,
    statistics: Statistics,
    /// Entries of each channel's message index of a chunk: time and offset.
    message_indexes: Vec<Vec<u8>>,
}

impl Container {
    /// The beginning of a file written by `library`.
    ///
    /// # Errors
    /// Like all here only for what cannot be a record at all: lengths that do not fit into their fields.
    pub(crate) fn new(library: &str) -> BinResult<Self> {
        let mut out = MAGIC.to_vec();
        record(&mut out, op::HEADER, &Header { profile: PROFILE.to_string(), library: library.to_string() }, &[])?;
        Ok(Container {
            out,
            taken: 0,
            checksum: Hasher::new(),
            schema_numbers: BTreeMap::new(),
            schemas: Vec::new(),
            channels: Vec::new(),
            chunk_indexes: Vec::new(),
            attachment_indexes: Vec::new(),
            metadata_indexes: Vec::new(),
            statistics: Statistics::default(),
            message_indexes: Vec::new(),
        })
    }

    /// Gives everything new to `write`, and counts it as part of the file from then on.
    pub(crate) fn take<E>(&mut self, write: impl FnOnce(&[u8]) -> Result<(), E>) -> Result<(), E> {
        self.checksum.update(&self.out);
        self.taken += self.out.len() as u64;
        let written = write(&self.out);
        self.out.clear();
        written
    }

    /// Length of the bytes that have been taken.
    pub(crate) fn length(&self) -> u64 {
        self.taken
    }

    /// The place of the next record in the file.
    fn position(&self) -> u64 {
        self.taken + self.out.len() as u64
    }

    /// Adds a channel for messages of this definition. `None` if there are more channels than the format can tell apart. Its records for a chunk go
    /// into `batch`.
    pub(crate) fn channel(
        &mut self,
        topic: &str,
        definition: &Definition,
        durability: Durability,
        batch: &mut Batch,
    ) -> BinResult<Option<u16>> {
        let Ok(id) = u16::try_from(self.message_indexes.len()) else { return Ok(None) };
        // Zero stands for no schema; there are no more schemas than channels.
        let next = self.schema_numbers.len() as u16 + 1;
        let schema_id = *self.schema_numbers.entry(definition.name).or_insert(next);
        if schema_id == next {
            let start = self.schemas.len();
            let header =
                SchemaHeader { id: next, name: definition.name.to_string(), encoding: SCHEMA_ENCODING.to_string() };
            let text = definition.schema();
            record(&mut self.schemas, op::SCHEMA, &header, &[&(text.len() as u32).to_le_bytes(), text.as_bytes()])?;
            batch.define(&self.schemas[start..]);
            self.statistics.schema_count += 1;
        }
        let start = self.channels.len();
        let (topic, message_encoding) = (topic.to_string(), MESSAGE_ENCODING.to_string());
        let channel = Channel { id, schema_id, topic, message_encoding, metadata: durability.metadata() };
        record(&mut self.channels, op::CHANNEL, &channel, &[])?;
        batch.define(&self.channels[start..]);
        self.statistics.channel_count += 1;
        self.message_indexes.push(Vec::new());
        Ok(Some(id))
    }

    /// Adds a metadata record.
    pub(crate) fn metadata(&mut self, metadata: &Metadata) -> BinResult<()> {
        let offset = self.position();
        let length = record(&mut self.out, op::METADATA, metadata, &[])?;
        let index = MetadataIndex { offset, length, name: metadata.name.clone() };
        self.statistics.metadata_count += 1;
        record(&mut self.metadata_indexes, op::METADATA_INDEX, &index, &[]).map(drop)
    }

    /// Adds an attachment.
    pub(crate) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> BinResult<()> {
        let (offset, start) = (self.position(), self.out.len());
        let (name, media_type, data_size) = (name.to_string(), media_type.to_string(), data.len() as u64);
        let header = AttachmentHeader { log_time: 0, create_time: 0, name, media_type };
        let length = record(&mut self.out, op::ATTACHMENT, &header, &[&data_size.to_le_bytes(), data, &[0; 4]])?;
        let end = self.out.len() - 4;
        let checksum = crc32fast::hash(&self.out[start + RECORD_HEADER..end]);
        self.out[end..].copy_from_slice(&checksum.to_le_bytes());
        let AttachmentHeader { log_time, create_time, name, media_type } = header;
        let index = AttachmentIndex { offset, length, log_time, create_time, data_size, name, media_type };
        self.statistics.attachment_count += 1;
        record(&mut self.attachment_indexes, op::ATTACHMENT_INDEX, &index, &[]).map(drop)
    }

    /// Completes the chunk of a batch, with its indexes, as the next part of the file, and puts it into the emptied `chunk`; everything
    /// before it has been taken. Its records are packed, if that makes them shorter.
    pub(crate) fn chunk(&mut self, batch: &Batch, packing: &mut Packing, chunk: &mut Vec<u8>) -> BinResult<()> {
        let (entries, records) = batch.from(0);
        let times = time_range(entries);
        self.count(entries, times);
        let mut header = chunk_header(times, records.len() as u64, crc32fast::hash(records));
        let mut content = records;
        if let Some((name, packed)) = packing.pack(batch)? {
            (header.compression, header.compressed_size) = (name.to_string(), packed.len() as u64);
            content = packed;
        }
        chunk.clear();
        record(chunk, op::CHUNK, &header, &[content])?;
        self.index(chunk, times, header)?;
        self.checksum.update(chunk);
        self.taken += chunk.len() as u64;
        Ok(())
    }

    /// Counts messages, and remembers where they are among the records of their chunk.
    fn count(&mut self, entries: &[Entry], times: (u64, u64)) {
        self.message_indexes.iter_mut().for_each(Vec::clear);
        for entry in entries {
            let index = &mut self.message_indexes[usize::from(entry.channel)];
            index.extend_from_slice(&entry.time.to_le_bytes());
            index.extend_from_slice(&(entry.offset as u64).to_le_bytes());
        }
        let statistics = &mut self.statistics;
        if !entries.is_empty() {
            let first = if statistics.message_count == 0 { times.0 } else { statistics.message_start_time };
            statistics.message_start_time = first.min(times.0);
            statistics.message_end_time = statistics.message_end_time.max(times.1);
        }
        statistics.message_count += entries.len() as u64;
        statistics.chunk_count += 1;
    }

    /// Adds the indexes of the counted messages behind their chunk, and the index of the chunk to the summary.
    fn index(&mut self, chunk: &mut Vec<u8>, times: (u64, u64), header: ChunkHeader) -> BinResult<()> {
        let chunk_length = chunk.len() as u64;
        let mut message_index_offsets = BTreeMap::new();
        for (channel, index) in (0_u16..).zip(&self.message_indexes).filter(|(_, index)| !index.is_empty()) {
            message_index_offsets.insert(channel, self.taken + chunk.len() as u64);
            record(chunk, op::MESSAGE_INDEX, &channel, &[&(index.len() as u32).to_le_bytes(), index])?;
            *self.statistics.channel_message_counts.entry(channel).or_default() += index.len() as u64 / 16;
        }
        let index = ChunkIndex {
            message_start_time: times.0,
            message_end_time: times.1,
            chunk_start_offset: self.taken,
            chunk_length,
            message_index_offsets,
            message_index_length: chunk.len() as u64 - chunk_length,
            compression: header.compression,
            compressed_size: header.compressed_size,
            uncompressed_size: header.uncompressed_size,
        };
        record(&mut self.chunk_indexes, op::CHUNK_INDEX, &index, &[]).map(drop)
    }

    /// Adds the records after the last chunk and metadata.
    pub(crate) fn finish(&mut self) -> BinResult<()> {
        let mut checksum = self.checksum.clone();
        checksum.update(&self.out);
        record(&mut self.out, op::DATA_END, &DataEnd { data_section_crc: checksum.finalize() }, &[])?;
        let (start, summary_start) = (self.out.len(), self.position());
        let mut statistics = Vec::new();
        record(&mut statistics, op::STATISTICS, &self.statistics, &[])?;
        let mut offsets = Vec::new();
        for (group_opcode, records) in [
            (op::SCHEMA, &self.schemas),
            (op::CHANNEL, &self.channels),
            (op::STATISTICS, &statistics),
            (op::CHUNK_INDEX, &self.chunk_indexes),
            (op::ATTACHMENT_INDEX, &self.attachment_indexes),
            (op::METADATA_INDEX, &self.metadata_indexes),
        ] {
            if !records.is_empty() {
                let group_start = self.taken + self.out.len() as u64;
                let offset = SummaryOffset { group_opcode, group_start, group_length: records.len() as u64 };
                record(&mut offsets, op::SUMMARY_OFFSET, &offset, &[])?;
                self.out.extend_from_slice(records);
            }
        }
        let summary_offset_start = self.position();
        self.out.extend_from_slice(&offsets);
        record(&mut self.out, op::FOOTER, &Footer { summary_start, summary_offset_start, summary_crc: 0 }, &[])?;
        // The checksum is of the summary and of the footer before it.
        let end = self.out.len() - 4;
        let checksum = crc32fast::hash(&self.out[start..end]);
        self.out[end..].copy_from_slice(&checksum.to_le_bytes());
        self.out.extend_from_slice(MAGIC);
        Ok(())
    }
}

/// The messages of a batch from number `first` on as a chunk that no index knows.
pub(crate) fn encode_provisional_chunk(batch: &Batch, first: usize, out: &mut Vec<u8>) -> BinResult<()> {
    encode_alone(batch.from(first), out)
}

/// The messages of a batch from number `first` on, as many as make no more than `size` bytes or else one, as such a chunk; returns how many.
pub(crate) fn encode_piece(batch: &Batch, first: usize, size: usize, out: &mut Vec<u8>) -> BinResult<usize> {
    let piece = batch.piece(first, size);
    encode_alone(piece, out).map(|()| piece.0.len())
}

fn encode_alone((entries, records): (&[Entry], &[u8]), out: &mut Vec<u8>) -> BinResult<()> {
    let header = chunk_header(time_range(entries), records.len() as u64, crc32fast::hash(records));
    record(out, op::CHUNK, &header, &[records]).map(drop)
}

fn time_range(entries: &[Entry]) -> (u64, u64) {
    let times = || entries.iter().map(|entry| entry.time);
    (times().min().unwrap_or(0), times().max().unwrap_or(0))
}

fn chunk_header((first, last): (u64, u64), size: u64, checksum: u32) -> ChunkHeader {
    ChunkHeader {
        message_start_time: first,
        message_end_time: last,
        uncompressed_size: size,
        uncompressed_crc: checksum,
        compression: String::new(),
        compressed_size: size,
    }
}

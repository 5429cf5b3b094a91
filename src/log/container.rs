//! The MCAP container: records, chunks, and the summary that lets readers find them.
//!
//! ```text
//!     magic  header | metadata  attachments | chunk  message indexes | chunk  message indexes | … | metadata   data section
//!     data end | schemas  channels  statistics  chunk, attachment and metadata indexes | summary offsets       summary section
//!     footer  magic
//! ```
//!
//! A record is an opcode (1 byte), the length of its content (8 bytes) and the content; numbers are little endian, strings have
//! their length (4 bytes) before them, and so have lists and maps (in bytes). The first chunk begins with all schemas and
//! channels. Chunks are not compressed: what compresses well, names, is the smaller part of a log, and the work would be as much
//! as all else about it (benches/README.md).
//!
//! A writer of our own because a message passes through that of the `mcap` crate in seven pieces, each through three layers: a third of
//! what a log without compression cost (benches/README.md). Source: MCAP format specification (mcap.dev/spec).

use super::batch::{Batch, Entry, RECORD_HEADER};
use crc32fast::Hasher;
use std::collections::BTreeMap;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

const HEADER: u8 = 0x01;
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const CHUNK: u8 = 0x06;
const MESSAGE_INDEX: u8 = 0x07;
const CHUNK_INDEX: u8 = 0x08;
const ATTACHMENT: u8 = 0x09;
const ATTACHMENT_INDEX: u8 = 0x0a;
const STATISTICS: u8 = 0x0b;
const METADATA: u8 = 0x0c;
const METADATA_INDEX: u8 = 0x0d;
const SUMMARY_OFFSET: u8 = 0x0e;
const DATA_END: u8 = 0x0f;

/// The content of a record.
trait Content {
    fn unsigned(&mut self, value: u64);
    fn text(&mut self, text: &str);
    /// The length of what `content` adds, in four bytes, and that.
    fn sized(&mut self, content: impl FnOnce(&mut Vec<u8>));
    fn record(&mut self, opcode: u8, content: impl FnOnce(&mut Vec<u8>));
}

impl Content for Vec<u8> {
    fn unsigned(&mut self, value: u64) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.sized(|out| out.extend_from_slice(text.as_bytes()));
    }

    fn sized(&mut self, content: impl FnOnce(&mut Vec<u8>)) {
        let start = self.len();
        self.extend_from_slice(&[0; 4]);
        content(self);
        let length = (self.len() - start - 4) as u32;
        self[start..start + 4].copy_from_slice(&length.to_le_bytes());
    }

    fn record(&mut self, opcode: u8, content: impl FnOnce(&mut Vec<u8>)) {
        let start = self.len();
        self.push(opcode);
        self.unsigned(0);
        content(self);
        let length = (self.len() - start - RECORD_HEADER) as u64;
        self[start + 1..start + RECORD_HEADER].copy_from_slice(&length.to_le_bytes());
    }
}

/// Records of one kind for the summary.
#[derive(Default)]
struct Group {
    records: Vec<u8>,
    count: u32,
}

impl Group {
    fn add(&mut self, opcode: u8, content: impl FnOnce(&mut Vec<u8>)) {
        self.records.record(opcode, content);
        self.count += 1;
    }
}

/// An MCAP file as far as it has been encoded.
pub(super) struct Container {
    /// What has not been taken yet.
    out: Vec<u8>,
    /// Length of what has been taken.
    taken: u64,
    checksum: Hasher,
    /// Names of schemas and their numbers.
    schema_numbers: BTreeMap<String, u16>,
    schemas: Group,
    channels: Group,
    /// Schemas and channels that are in no chunk yet.
    definitions: Vec<u8>,
    /// Messages of each channel.
    counts: Vec<u64>,
    /// Times of the first and the last message.
    times: Option<(u64, u64)>,
    chunk_indexes: Group,
    attachment_indexes: Group,
    metadata_indexes: Group,
    /// Entries of each channel's message index of a chunk.
    message_indexes: Vec<Vec<u8>>,
}

impl Container {
    /// The beginning of a file written by `library`.
    pub(super) fn new(library: &str) -> Self {
        let mut out = MAGIC.to_vec();
        out.record(HEADER, |out| {
            out.text("");
            out.text(library);
        });
        Container {
            out,
            taken: 0,
            checksum: Hasher::new(),
            schema_numbers: BTreeMap::new(),
            schemas: Group::default(),
            channels: Group::default(),
            definitions: Vec::new(),
            counts: Vec::new(),
            times: None,
            chunk_indexes: Group::default(),
            attachment_indexes: Group::default(),
            metadata_indexes: Group::default(),
            message_indexes: Vec::new(),
        }
    }

    /// Gives everything new to `write`, and counts it as part of the file from then on.
    pub(super) fn take<E>(&mut self, write: impl FnOnce(&[u8]) -> Result<(), E>) -> Result<(), E> {
        self.checksum.update(&self.out);
        self.taken += self.out.len() as u64;
        let written = write(&self.out);
        self.out.clear();
        written
    }

    /// Where in the file the next record will be.
    fn position(&self) -> u64 {
        self.taken + self.out.len() as u64
    }

    /// Adds a channel for messages of the `schema` (name, encoding, data), of which there is one for each name. `None` if there
    /// are more channels than the format can tell apart.
    pub(super) fn channel(&mut self, topic: &str, schema: (&str, &str, &[u8]), encoding: &str) -> Option<u16> {
        let (name, schema_encoding, data) = schema;
        let channel = u16::try_from(self.counts.len()).ok()?;
        let number = match self.schema_numbers.get(name) {
            Some(&number) => number,
            None => {
                // Zero stands for no schema.
                let number = u16::try_from(self.schema_numbers.len() + 1).ok()?;
                let start = self.schemas.records.len();
                self.schemas.add(SCHEMA, |out| {
                    out.extend_from_slice(&number.to_le_bytes());
                    out.text(name);
                    out.text(schema_encoding);
                    out.sized(|out| out.extend_from_slice(data));
                });
                self.definitions.extend_from_slice(&self.schemas.records[start..]);
                self.schema_numbers.insert(name.to_string(), number);
                number
            }
        };
        let start = self.channels.records.len();
        self.channels.add(CHANNEL, |out| {
            out.extend_from_slice(&channel.to_le_bytes());
            out.extend_from_slice(&number.to_le_bytes());
            out.text(topic);
            out.text(encoding);
            out.sized(|_| ());
        });
        self.definitions.extend_from_slice(&self.channels.records[start..]);
        self.counts.push(0);
        self.message_indexes.push(Vec::new());
        Some(channel)
    }

    /// Adds a metadata record.
    pub(super) fn metadata(&mut self, name: &str, entries: &BTreeMap<String, String>) {
        let offset = self.position();
        self.out.record(METADATA, |out| {
            out.text(name);
            out.sized(|out| {
                for (key, value) in entries {
                    out.text(key);
                    out.text(value);
                }
            });
        });
        let length = self.position() - offset;
        self.metadata_indexes.add(METADATA_INDEX, |out| {
            out.unsigned(offset);
            out.unsigned(length);
            out.text(name);
        });
    }

    /// Adds an attachment.
    pub(super) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) {
        let offset = self.position();
        self.out.record(ATTACHMENT, |out| {
            let start = out.len();
            out.unsigned(0);
            out.unsigned(0);
            out.text(name);
            out.text(media_type);
            out.unsigned(data.len() as u64);
            out.extend_from_slice(data);
            let checksum = crc32fast::hash(&out[start..]);
            out.extend_from_slice(&checksum.to_le_bytes());
        });
        let length = self.position() - offset;
        self.attachment_indexes.add(ATTACHMENT_INDEX, |out| {
            out.unsigned(offset);
            out.unsigned(length);
            out.unsigned(0);
            out.unsigned(0);
            out.unsigned(data.len() as u64);
            out.text(name);
            out.text(media_type);
        });
    }

    /// Adds all messages of a batch as a chunk.
    pub(super) fn chunk(&mut self, batch: &Batch) {
        let (entries, records) = batch.from(0);
        if entries.is_empty() && self.definitions.is_empty() {
            return;
        }
        let times = time_range(entries);
        self.times = match (self.times, entries.is_empty()) {
            (known, true) => known,
            (None, false) => Some(times),
            (Some((first, last)), false) => Some((first.min(times.0), last.max(times.1))),
        };
        let (start, at) = (self.out.len(), self.position());
        let definitions = std::mem::take(&mut self.definitions);
        self.message_indexes.iter_mut().for_each(Vec::clear);
        let mut offset = definitions.len() as u64;
        for entry in entries {
            let channel = usize::from(entry.channel);
            self.counts[channel] += 1;
            self.message_indexes[channel].unsigned(entry.time);
            self.message_indexes[channel].unsigned(offset);
            offset += entry.length() as u64;
        }
        encode_chunk(times, [&definitions, records], &mut self.out);
        let chunk_length = (self.out.len() - start) as u64;
        let size = (definitions.len() + records.len()) as u64;
        let Container { out, message_indexes, chunk_indexes, .. } = self;
        chunk_indexes.add(CHUNK_INDEX, |chunk_index| {
            chunk_index.unsigned(times.0);
            chunk_index.unsigned(times.1);
            chunk_index.unsigned(at);
            chunk_index.unsigned(chunk_length);
            chunk_index.sized(|offsets| {
                for (channel, index) in (0_u16..).zip(message_indexes).filter(|(_, index)| !index.is_empty()) {
                    offsets.extend_from_slice(&channel.to_le_bytes());
                    offsets.unsigned(at + (out.len() - start) as u64);
                    out.record(MESSAGE_INDEX, |out| {
                        out.extend_from_slice(&channel.to_le_bytes());
                        out.sized(|out| out.extend_from_slice(index));
                    });
                }
            });
            chunk_index.unsigned((out.len() - start) as u64 - chunk_length);
            chunk_index.text("");
            chunk_index.unsigned(size);
            chunk_index.unsigned(size);
        });
    }

    /// Adds what comes after the last chunk.
    pub(super) fn finish(&mut self) {
        let mut checksum = self.checksum.clone();
        checksum.update(&self.out);
        self.out.record(DATA_END, |out| out.extend_from_slice(&checksum.finalize().to_le_bytes()));
        let mut statistics = Group::default();
        statistics.add(STATISTICS, |out| {
            let (first, last) = self.times.unwrap_or_default();
            out.unsigned(self.counts.iter().sum());
            out.extend_from_slice(&(self.schemas.count as u16).to_le_bytes());
            for group in [&self.channels, &self.attachment_indexes, &self.metadata_indexes, &self.chunk_indexes] {
                out.extend_from_slice(&group.count.to_le_bytes());
            }
            out.unsigned(first);
            out.unsigned(last);
            out.sized(|out| {
                for (channel, &count) in (0_u16..).zip(&self.counts) {
                    if count > 0 {
                        out.extend_from_slice(&channel.to_le_bytes());
                        out.unsigned(count);
                    }
                }
            });
        });
        let (start, at) = (self.out.len(), self.position());
        let mut offsets = Vec::new();
        for (opcode, group) in [
            (SCHEMA, &self.schemas),
            (CHANNEL, &self.channels),
            (STATISTICS, &statistics),
            (CHUNK_INDEX, &self.chunk_indexes),
            (ATTACHMENT_INDEX, &self.attachment_indexes),
            (METADATA_INDEX, &self.metadata_indexes),
        ] {
            if group.count > 0 {
                offsets.record(SUMMARY_OFFSET, |out| {
                    out.push(opcode);
                    out.unsigned(at + (self.out.len() - start) as u64);
                    out.unsigned(group.records.len() as u64);
                });
                self.out.extend_from_slice(&group.records);
            }
        }
        let offsets_at = at + (self.out.len() - start) as u64;
        self.out.extend_from_slice(&offsets);
        self.out.record(FOOTER, |out| {
            out.unsigned(at);
            out.unsigned(offsets_at);
            out.extend_from_slice(&[0; 4]);
        });
        // The checksum is of the summary and of the footer before it.
        let end = self.out.len() - 4;
        let checksum = crc32fast::hash(&self.out[start..end]);
        self.out[end..].copy_from_slice(&checksum.to_le_bytes());
        self.out.extend_from_slice(MAGIC);
    }
}

/// The messages of a batch from number `first` on as a chunk that no index knows.
pub(super) fn encode_provisional_chunk(batch: &Batch, first: usize, out: &mut Vec<u8>) {
    let (entries, records) = batch.from(first);
    encode_chunk(time_range(entries), [&[], records], out);
}

fn time_range(entries: &[Entry]) -> (u64, u64) {
    let times = || entries.iter().map(|entry| entry.time);
    (times().min().unwrap_or(0), times().max().unwrap_or(0))
}

fn encode_chunk((first, last): (u64, u64), content: [&[u8]; 2], out: &mut Vec<u8>) {
    let size = content.iter().map(|piece| piece.len()).sum::<usize>() as u64;
    let mut checksum = Hasher::new();
    content.iter().for_each(|piece| checksum.update(piece));
    out.record(CHUNK, |out| {
        out.unsigned(first);
        out.unsigned(last);
        out.unsigned(size);
        out.extend_from_slice(&checksum.finalize().to_le_bytes());
        out.text("");
        out.unsigned(size);
        content.iter().for_each(|piece| out.extend_from_slice(piece));
    });
}

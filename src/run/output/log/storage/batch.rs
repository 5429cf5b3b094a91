//! Encoded messages as the records of a chunk. Source: MCAP format specification
//! (mcap.dev/spec), "Message": opcode 5 (1 byte), length (8 bytes), channel (2), sequence (4), log time (8), publish time (8), data;
//! all numbers little endian.

/// Opcode of a message.
const MESSAGE: u8 = 0x05;

/// Opcode and length of a record.
pub(crate) const RECORD_HEADER: usize = 1 + 8;

/// Bytes of a message record before its data.
pub(crate) const MESSAGE_DATA: usize = RECORD_HEADER + 2 + 4 + 8 + 8;

/// The place of a message.
#[derive(Clone, Copy)]
pub(crate) struct Entry {
    /// The channel, as [`crate::output::log::storage::file::MessageSink::channel`] gave it.
    pub channel: u16,
    /// Log time and publish time in nanoseconds.
    pub time: u64,
    /// The place of its record among the records.
    pub offset: usize,
    /// Length of the record.
    pub length: usize,
}

/// Messages in their order.
#[derive(Default)]
pub(crate) struct Batch {
    entries: Vec<Entry>,
    records: Vec<u8>,
}

impl Batch {
    /// Adds a message like `template`; returns its data.
    pub(crate) fn push(&mut self, channel: u16, nanoseconds: u64, template: &[u8]) -> &mut [u8] {
        let offset = self.records.len();
        let mut framing = [0; MESSAGE_DATA];
        framing[0] = MESSAGE;
        framing[1..9].copy_from_slice(&((MESSAGE_DATA - RECORD_HEADER + template.len()) as u64).to_le_bytes());
        framing[9..11].copy_from_slice(&channel.to_le_bytes());
        // No sequence numbers: the order of the messages says the same.
        framing[15..23].copy_from_slice(&nanoseconds.to_le_bytes());
        framing[23..31].copy_from_slice(&nanoseconds.to_le_bytes());
        self.records.extend_from_slice(&framing);
        self.records.extend_from_slice(template);
        let length = MESSAGE_DATA + template.len();
        self.entries.push(Entry { channel, time: nanoseconds, offset, length });
        &mut self.records[offset + MESSAGE_DATA..]
    }

    /// Adds records that are not messages.
    pub(crate) fn define(&mut self, records: &[u8]) {
        self.records.extend_from_slice(records);
    }

    /// The messages in their order, each with its data.
    pub(crate) fn messages(&self) -> impl Iterator<Item = (Entry, &[u8])> {
        self.entries
            .iter()
            .map(|&entry| (entry, &self.records[entry.offset + MESSAGE_DATA..entry.offset + entry.length]))
    }

    /// The messages from number `first` on, and the records from there on.
    pub(crate) fn from(&self, first: usize) -> (&[Entry], &[u8]) {
        let records = &self.records;
        let entries = &self.entries[first.min(self.entries.len())..];
        let start = if first == 0 { 0 } else { entries.first().map_or(records.len(), |entry| entry.offset) };
        (entries, &records[start..])
    }

    /// The messages from number `first` on whose records are no longer than `size` together, or one that is longer alone, and these records.
    pub(super) fn piece(&self, first: usize, size: usize) -> (&[Entry], &[u8]) {
        let (entries, records) = self.from(first);
        let end = |entry: &Entry| entry.offset + entry.length;
        let start = self.size() - records.len();
        let count = entries.partition_point(|entry| end(entry) - start <= size).max(1).min(entries.len());
        (&entries[..count], &records[..entries[..count].last().map_or(0, |last| end(last) - start)])
    }

    /// Number of messages.
    pub(crate) fn count(&self) -> usize {
        self.entries.len()
    }

    /// Length of all records.
    pub(crate) fn size(&self) -> usize {
        self.records.len()
    }

    /// The size with one message more.
    pub(crate) fn size_with(&self, data: &[u8]) -> usize {
        self.size() + MESSAGE_DATA + data.len()
    }

    /// Forgets all messages and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
        self.records.clear();
    }
}

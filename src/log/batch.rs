//! Encoded messages on their way into the file, as the records they will be there.
//!
//! Source: MCAP format specification (mcap.dev/spec), "Message": opcode 5 (1 byte), length (8 bytes), channel (2), sequence (4),
//! log time (8), publish time (8), data; all numbers little endian.

/// Opcode of a message.
const MESSAGE: u8 = 0x05;

/// Opcode and length of a record.
pub(super) const RECORD_HEADER: usize = 1 + 8;

/// Bytes of a message record besides its data.
const FRAMING: usize = RECORD_HEADER + 2 + 4 + 8 + 8;

/// Where a message is.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    /// The channel, as [`super::file::LogChannels::channel`] gave it.
    pub channel: u16,
    /// Log time and publish time in nanoseconds.
    pub time: u64,
    /// Length of the record.
    length: usize,
}

impl Entry {
    /// Length of the record.
    pub(super) fn length(&self) -> usize {
        self.length
    }
}

/// Messages in their order.
#[derive(Default)]
pub(super) struct Batch {
    entries: Vec<Entry>,
    /// The records, one after the other.
    records: Vec<u8>,
}

impl Batch {
    /// Adds a message.
    pub(super) fn push(&mut self, channel: u16, nanoseconds: u64, data: &[u8]) {
        let mut framing = [0; FRAMING];
        framing[0] = MESSAGE;
        framing[1..9].copy_from_slice(&((FRAMING - RECORD_HEADER + data.len()) as u64).to_le_bytes());
        framing[9..11].copy_from_slice(&channel.to_le_bytes());
        // No sequence numbers: the order of the messages says the same.
        framing[15..23].copy_from_slice(&nanoseconds.to_le_bytes());
        framing[23..31].copy_from_slice(&nanoseconds.to_le_bytes());
        self.records.extend_from_slice(&framing);
        self.records.extend_from_slice(data);
        self.entries.push(Entry { channel, time: nanoseconds, length: FRAMING + data.len() });
    }

    /// The messages in their order, each with its data.
    pub(super) fn messages(&self) -> impl Iterator<Item = (Entry, &[u8])> {
        self.records_of(0).map(|(entry, record)| (entry, &record[FRAMING..]))
    }

    /// The messages from number `first` on, each with its record.
    fn records_of(&self, first: usize) -> impl Iterator<Item = (Entry, &[u8])> {
        let (entries, mut rest) = self.from(first);
        entries.iter().map(move |&entry| {
            let (record, after) = rest.split_at(entry.length);
            rest = after;
            (entry, record)
        })
    }

    /// The messages from number `first` on, and their records in one piece.
    pub(super) fn from(&self, first: usize) -> (&[Entry], &[u8]) {
        let (before, entries) = self.entries.split_at(first.min(self.entries.len()));
        (entries, &self.records[before.iter().map(Entry::length).sum()..])
    }

    /// Number of messages.
    pub(super) fn count(&self) -> usize {
        self.entries.len()
    }

    /// Length of all records.
    pub(super) fn size(&self) -> usize {
        self.records.len()
    }

    /// Forgets all messages and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.entries.clear();
        self.records.clear();
    }

    /// Adds the messages of another batch.
    pub(super) fn append(&mut self, other: &Batch) {
        self.entries.extend_from_slice(&other.entries);
        self.records.extend_from_slice(&other.records);
    }

    /// Adds messages of another batch, from number `first` on, as long as all are not larger than `limit`, and at least one;
    /// returns the number of the first that was not added.
    pub(super) fn append_up_to(&mut self, limit: usize, other: &Batch, first: usize) -> usize {
        let mut next = first;
        for (entry, record) in other.records_of(first) {
            if !self.entries.is_empty() && self.size() + record.len() > limit {
                break;
            }
            self.entries.push(entry);
            self.records.extend_from_slice(record);
            next += 1;
        }
        next
    }
}

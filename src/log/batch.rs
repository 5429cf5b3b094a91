//! Encoded messages on their way into the file.

use mcap::records::MessageHeader;
use mcap::{McapError, Writer};
use std::io::{Seek, Write};

/// Bytes of a message record besides its data: opcode, length, channel, sequence and two times.
const FRAMING: usize = 1 + 8 + 2 + 4 + 8 + 8;

/// Where a message is.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    /// The channel, as [`super::file::LogChannels::channel`] gave it.
    pub channel: u16,
    /// Log time and publish time in nanoseconds.
    pub time: u64,
    /// Length of the data.
    length: usize,
}

/// Messages in their order.
#[derive(Default)]
pub(super) struct Batch {
    entries: Vec<Entry>,
    /// The data of all messages, one after the other.
    data: Vec<u8>,
}

impl Batch {
    /// Adds a message.
    pub(super) fn push(&mut self, channel: u16, nanoseconds: u64, data: &[u8]) {
        self.entries.push(Entry { channel, time: nanoseconds, length: data.len() });
        self.data.extend_from_slice(data);
    }

    /// The messages in their order, each with its data.
    pub(super) fn messages(&self) -> impl Iterator<Item = (Entry, &[u8])> {
        self.messages_from(0)
    }

    /// The messages from number `first` on.
    fn messages_from(&self, first: usize) -> impl Iterator<Item = (Entry, &[u8])> {
        let (before, entries) = self.entries.split_at(first.min(self.entries.len()));
        let mut rest = &self.data[before.iter().map(|entry| entry.length).sum()..];
        entries.iter().map(move |&entry| {
            let (data, after) = rest.split_at(entry.length);
            rest = after;
            (entry, data)
        })
    }

    /// Number of messages.
    pub(super) fn count(&self) -> usize {
        self.entries.len()
    }

    /// Size in a chunk.
    pub(super) fn size(&self) -> usize {
        self.data.len() + FRAMING * self.entries.len()
    }

    /// Forgets all messages and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.entries.clear();
        self.data.clear();
    }

    /// Adds the messages of another batch.
    pub(super) fn append(&mut self, other: &Batch) {
        self.entries.extend_from_slice(&other.entries);
        self.data.extend_from_slice(&other.data);
    }

    /// Adds messages of another batch, from number `first` on, as long as all are not larger than `limit`, and at least one;
    /// returns the number of the first that was not added.
    pub(super) fn append_up_to(&mut self, limit: usize, other: &Batch, first: usize) -> usize {
        let mut next = first;
        for (entry, data) in other.messages_from(first) {
            if !self.entries.is_empty() && self.size() + FRAMING + data.len() > limit {
                break;
            }
            self.entries.push(entry);
            self.data.extend_from_slice(data);
            next += 1;
        }
        next
    }

    /// Writes the messages from number `first` on into the open chunk of a writer.
    pub(super) fn write_to<W: Write + Seek>(&self, writer: &mut Writer<W>, first: usize) -> Result<(), McapError> {
        self.messages_from(first).try_for_each(|(Entry { channel, time, .. }, data)| {
            // No sequence numbers: the order of the messages says the same.
            let header = MessageHeader { channel_id: channel, sequence: 0, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, data)
        })
    }
}

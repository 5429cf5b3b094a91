//! Encoded messages on their way into the file.

use mcap::records::MessageHeader;
use mcap::{McapError, Writer};
use std::io::{Seek, Write};

/// Bytes of a message record besides its data: kind, length, channel, sequence and two times.
const FRAMING: usize = 1 + 8 + 2 + 4 + 8 + 8;

/// Messages in their order.
#[derive(Default)]
pub(super) struct Batch {
    /// Each header with the length of its data.
    headers: Vec<(MessageHeader, usize)>,
    /// The data of all messages, one after the other.
    data: Vec<u8>,
}

impl Batch {
    /// Adds a message of a channel of [`super::file::LogFile::channel`].
    pub(super) fn push(&mut self, channel: u16, nanoseconds: u64, data: &[u8]) {
        // No sequence numbers: the order of the messages says the same.
        let header =
            MessageHeader { channel_id: channel, sequence: 0, log_time: nanoseconds, publish_time: nanoseconds };
        self.push_message(header, data);
    }

    pub(super) fn push_message(&mut self, header: MessageHeader, data: &[u8]) {
        self.headers.push((header, data.len()));
        self.data.extend_from_slice(data);
    }

    /// The messages in their order.
    pub(super) fn messages(&self) -> impl Iterator<Item = (MessageHeader, &[u8])> {
        let mut rest = &self.data[..];
        self.headers.iter().map(move |&(header, length)| {
            let (data, after) = rest.split_at(length);
            rest = after;
            (header, data)
        })
    }

    /// Number of messages.
    pub(super) fn count(&self) -> usize {
        self.headers.len()
    }

    /// Uncompressed size in a chunk.
    pub(super) fn size(&self) -> usize {
        self.data.len() + FRAMING * self.headers.len()
    }

    /// Uncompressed size in a chunk, with one more message of this length.
    pub(super) fn size_with(&self, length: usize) -> usize {
        self.size() + FRAMING + length
    }

    /// Forgets all messages and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.headers.clear();
        self.data.clear();
    }

    /// Adds the messages of another batch.
    pub(super) fn append(&mut self, other: &Batch) {
        self.headers.extend_from_slice(&other.headers);
        self.data.extend_from_slice(&other.data);
    }

    /// Writes the messages from number `first` on into the open chunk of a writer.
    pub(super) fn write_to<W: Write + Seek>(&self, writer: &mut Writer<W>, first: usize) -> Result<(), McapError> {
        self.messages().skip(first).try_for_each(|(header, data)| writer.write_to_known_channel(&header, data))
    }
}

//! Chunks of samples packed as LZ4, with matches that are known instead of searched for.
//!
//! A message differs from the one before it on its channel in its numbers only. So each message is compared with it, eight bytes at a time. Equal
//! bytes become a match of LZ4 at their distance, and the rest literals. This finds the names and constants of a log, which are about half of it, in
//! one pass without tables. A general compressor costs as much as everything else about a sample.
//!
//! ```text
//!     frame     magic  descriptor | length of a block  block | … | end mark (4 zero bytes)
//!     block     sequence  sequence  …  last literals
//!     sequence  token (4 bits literal count, 4 bits match length − 4)  more of the count  literals  distance (2 bytes)  more of the length
//! ```
//!
//! A count of 15 goes on with bytes that are added to it, up to the first that is not 255. No match begins in the last twelve bytes of a
//! block. Blocks are short and end where a message ends, so that a chunk that is cut loses no more than one of them; matches reach back
//! into earlier blocks. Source: LZ4 block format description and LZ4 frame format description 1.6 (github.com/lz4/lz4/tree/dev/doc).

use crate::output::log::storage::batch::{Batch, Entry, MESSAGE_DATA};

/// The name of the compression in the file.
pub(crate) const NAME: &str = "lz4";

/// Magic number; version 1, matches may reach into earlier blocks, no checksums (chunks have their own); blocks up to 1 MB; checksum of
/// these two bytes.
const FRAME: [u8; 7] = [0x04, 0x22, 0x4d, 0x18, 0x40, 0x60, 0x96];

/// Longer chunks are one long message and stay as they are. It leaves room for a block that becomes longer than its records.
const LONGEST: usize = 1 << 18;

/// A block ends with the message that gives it this length.
const BLOCK: usize = 1 << 14;

/// Farthest match.
const FARTHEST: usize = u16::MAX as usize;

/// Least distance of the end of a match from the end of the block, in bytes.
const LAST_LITERALS: usize = 12;

/// Shortest match of the format, and the bytes that are compared at once, of which at least one is equal in each match here.
const SHORTEST: usize = 4;
const WORD: usize = 8;

/// Bytes of the encapsulation of a message, from which on its numbers are aligned.
const ENCAPSULATION: usize = 4;

/// Packs chunks; keeps its memory.
#[derive(Default)]
pub(crate) struct Repetitions {
    /// For each channel the beginning of its last message, and its length.
    last: Vec<(usize, usize)>,
    packed: Vec<u8>,
}

impl Repetitions {
    /// The records of a batch as a frame; `None` if that is no shorter, or they are too long.
    pub(crate) fn pack(&mut self, batch: &Batch) -> Option<&[u8]> {
        let (entries, records) = batch.from(0);
        if entries.is_empty() || records.len() > LONGEST {
            return None;
        }
        self.last.fill((0, 0));
        self.packed.clear();
        self.packed.extend_from_slice(&FRAME);
        let (mut first, mut start) = (0, 0);
        for (number, entry) in entries.iter().enumerate() {
            let is_last = number + 1 == entries.len();
            let end = if is_last { records.len() } else { entry.offset + entry.length };
            if is_last || end - start >= BLOCK {
                self.block(&entries[first..=number], &records[..end], start);
                (first, start) = (number + 1, end);
            }
        }
        self.packed.extend_from_slice(&[0; 4]);
        (self.packed.len() < records.len()).then_some(&self.packed)
    }

    /// Adds a block of these messages: the records from `start` on.
    fn block(&mut self, entries: &[Entry], records: &[u8], start: usize) {
        let before = self.packed.len();
        self.packed.extend_from_slice(&[0; 4]);
        let mut block = Block { records, out: &mut self.packed, written: start };
        for entry in entries {
            let channel = usize::from(entry.channel);
            if self.last.len() <= channel {
                self.last.resize(channel + 1, (0, 0));
            }
            let (before, length) = std::mem::replace(&mut self.last[channel], (entry.offset, entry.length));
            if length == entry.length && entry.offset - before <= FARTHEST {
                block.compare(entry.offset, entry.length, entry.offset - before);
            }
        }
        block.finish();
        let length = self.packed.len() - before - 4;
        self.packed[before..before + 4].copy_from_slice(&(length as u32).to_le_bytes());
    }
}

/// A block that is being written.
struct Block<'b> {
    /// The records up to its end.
    records: &'b [u8],
    out: &'b mut Vec<u8>,
    /// Bytes of the records that are in it, or in blocks before.
    written: usize,
}

impl Block<'_> {
    /// Adds the message at `start`, as far as it is like the one of the same length that is `distance` before it.
    fn compare(&mut self, start: usize, length: usize, distance: usize) {
        let end = (start + length).min(self.records.len().saturating_sub(LAST_LITERALS));
        // Numbers of a message are aligned to eight bytes after its encapsulation.
        let start = start + (MESSAGE_DATA + ENCAPSULATION) % WORD;
        if end < start {
            return;
        }
        let words = |from: usize, to: usize| self.records[from..to].as_chunks::<WORD>().0;
        let (new, old) = (words(start, end), words(start - distance, end - distance));
        let old = &old[..new.len()];
        let difference = |word: usize| u64::from_le_bytes(new[word]) ^ u64::from_le_bytes(old[word]);
        // Loops over indices: iterators would be calls here.
        let mut next = 0;
        loop {
            let from = next;
            while next < new.len() && new[next] != old[next] {
                next += 1;
            }
            if next == new.len() {
                return;
            }
            let first = next;
            while next < new.len() && new[next] == old[next] {
                next += 1;
            }
            // Equal bytes at the end of the word before, and at the beginning of the word after.
            let before = if first > from { difference(first - 1).leading_zeros() as usize / 8 } else { 0 };
            let behind = if next < new.len() { difference(next).trailing_zeros() as usize / 8 } else { 0 };
            self.sequence(start + WORD * first - before, before + WORD * (next - first) + behind, distance);
        }
    }

    /// Adds the literals up to `first`, and a match from there on.
    fn sequence(&mut self, first: usize, length: usize, distance: usize) {
        let literals = &self.records[self.written..first];
        let more = length - SHORTEST;
        self.out.push(((literals.len().min(15) << 4) | more.min(15)) as u8);
        self.count(literals.len());
        self.out.extend_from_slice(literals);
        self.out.extend_from_slice(&(distance as u16).to_le_bytes());
        self.count(more);
        self.written = first + length;
    }

    /// Adds what of a count is not in its token.
    fn count(&mut self, count: usize) {
        if count >= 15 {
            let rest = count - 15;
            self.out.resize(self.out.len() + rest / 255, 255);
            self.out.push((rest % 255) as u8);
        }
    }

    /// Adds the last literals.
    fn finish(mut self) {
        let literals = &self.records[self.written..];
        self.out.push((literals.len().min(15) << 4) as u8);
        self.count(literals.len());
        self.out.extend_from_slice(literals);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    /// The bytes that a reader of the format makes of the frame of a batch, and the length of the frame; `None` if the batch is not packed.
    fn unpacked(batch: &Batch) -> Option<(Vec<u8>, usize)> {
        let mut repetitions = Repetitions::default();
        let frame = repetitions.pack(batch)?;
        let mut records = Vec::new();
        lz4::Decoder::new(frame).expect("a frame").read_to_end(&mut records).expect("whole");
        Some((records, frame.len()))
    }

    /// Messages on three channels; in each, bytes at places of no pattern are other ones than before, some of them equal by chance.
    fn messages(count: usize, length: usize, one_changes_in: u64) -> Batch {
        let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
        let mut random = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            seed
        };
        let mut batch = Batch::default();
        let mut data = vec![7; length];
        for number in 0..count {
            for byte in &mut data {
                if random() % one_changes_in == 0 {
                    *byte = (random() % 3) as u8;
                }
            }
            // Every sixth is shorter than the one before on its channel.
            let shorter = if number % 6 == 5 { length / 7 } else { 0 };
            batch.push((number % 3) as u16, number as u64, &data[shorter..]);
        }
        batch
    }

    #[test]
    fn a_reader_of_lz4_finds_the_records_as_they_were() {
        let mut packed = 0;
        for length in [0, 1, 7, 8, 30, 257, 300, 5000, 30_000] {
            for one_changes_in in [1, 2, 9, 50, 1000, 100_000] {
                for count in [1, 2, 4, 7] {
                    let batch = messages(count, length, one_changes_in);
                    let records = batch.from(0).1;
                    let Some((found, frame)) = unpacked(&batch) else { continue };
                    assert!(found == records, "{count} messages of {length} bytes, 1 of {one_changes_in}");
                    assert!(frame < records.len());
                    packed += 1;
                }
            }
        }
        // Batches with one message a channel, or in which most bytes change, are not packed.
        assert!(packed > 40, "{packed} were packed");
    }

    #[test]
    fn what_repeats_is_written_once_and_what_does_not_stays_as_it_is() {
        // Ten equal messages of 5000 bytes. The first of each channel, a shorter one and the one after it have no match.
        let (_, frame) = unpacked(&messages(10, 5000, u64::MAX)).expect("packed");
        assert!(frame < 5 * 5000, "{frame} bytes");
        assert!(unpacked(&messages(1, 5000, 2)).is_none(), "one message has none before it");
        assert!(unpacked(&messages(10, 30_000, u64::MAX)).is_none(), "too long");
        // Three messages of one channel lie too far apart.
        assert!(unpacked(&messages(6, 40_000, u64::MAX)).is_none());
    }
}

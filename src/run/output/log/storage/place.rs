//! The end of a log on disk: changed so that at every moment, even in the middle of a write, all of it can be read.
//!
//! A log in progress is a final part, to which chunks are only ever added, and after it a provisional part: messages whose final chunk is not full
//! yet. They are written twice a second in small chunks of their own, one after the other.
//!
//! ```text
//!     final part | p₁ p₂ … p_n                                      provisional chunks, added at the end
//! ```
//!
//! The final chunk F takes the place of the provisional ones. To write over them would lose them all if the process
//! were killed half-way, so F is first written behind them, then they are covered by the header of a private record
//! (which readers skip, as the format asks of them), then F is written below the cover, and the cover is taken away:
//!
//! ```text
//!     final part | p₁ … p_n [private: too long … F                  a reader meets p₁ … p_n and then the end
//!     final part | [private: skip ……………………… ]F                      a reader meets F
//!     final part | [private: F₉… [private: skip … F]]F              the same
//!     final part | F [private: skip ……………………………… F]                the same
//!     final part | F                                                cut off
//! ```
//!
//! The two headers that switch from one picture to the next are nine bytes, written at once. Source: MCAP format
//! specification (mcap.dev/spec), "Records": opcode (1 byte), length (8 bytes), content; opcodes from 0x80 are private.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};

/// Opcode and length of a record.
const HEADER: u64 = 9;

/// The first opcode of the private range.
const PRIVATE: u8 = 0x80;

/// Bytes by which the record that readers shall not get past is longer than the file.
const BEYOND: u64 = 1 << 24;

/// DataEnd without checksum, Footer without summary, magic: what makes a file complete when there is room for no more.
const SHORT_END: [u8; 50] = [
    0x0f, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // DataEnd
    0x02, 20, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // Footer
    0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n', // magic
];

/// Something with bytes at offsets.
pub(crate) trait Place {
    /// Writes all bytes at an offset.
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()>;
    /// Cuts off everything behind a length.
    fn truncate(&mut self, length: u64) -> io::Result<()>;
    /// Waits until everything is safe from a power failure.
    fn sync(&mut self) -> io::Result<()>;
}

/// A file, or a pipe or device that takes bytes in their order only.
pub(crate) struct FilePlace {
    file: File,
    position: u64,
    is_regular: bool,
}

impl FilePlace {
    pub(crate) fn new(file: File, is_regular: bool) -> Self {
        FilePlace { file, position: 0, is_regular }
    }

    pub(crate) fn into_file(self) -> File {
        self.file
    }
}

impl Place for FilePlace {
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()> {
        if offset != self.position {
            self.position = self.file.seek(SeekFrom::Start(offset))?;
        }
        let mut rest = bytes;
        while !rest.is_empty() {
            match self.file.write(rest) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(count) => {
                    self.position += count as u64;
                    rest = &rest[count..];
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn truncate(&mut self, length: u64) -> io::Result<()> {
        if self.is_regular { self.file.set_len(length) } else { Ok(()) }
    }

    fn sync(&mut self) -> io::Result<()> {
        if self.is_regular { self.file.sync_data() } else { Ok(()) }
    }
}

/// The final and the provisional part of a log.
pub(crate) struct Tail<P> {
    place: P,
    /// Length of the final part.
    end: u64,
    /// Length of the provisional part.
    provisional: u64,
}

impl<P: Place> Tail<P> {
    /// An empty log in an empty place.
    pub(crate) fn new(place: P) -> Self {
        Tail { place, end: 0, provisional: 0 }
    }

    pub(crate) fn place(&mut self) -> &mut P {
        &mut self.place
    }

    /// Adds bytes to the final part; the provisional part, whose messages they hold, vanishes.
    pub(crate) fn extend(&mut self, bytes: &[u8]) -> io::Result<()> {
        let length = bytes.len() as u64;
        if self.provisional == 0 || length < HEADER {
            self.place.write_at(bytes, self.end)?;
            self.end += length;
            return Ok(());
        }
        // A second copy, behind everything that the chunk and a header after it will cover.
        let copy = self.end + HEADER + self.provisional.max(length);
        let mut behind = private_header(length + BEYOND).to_vec();
        behind.resize((copy - self.end - self.provisional) as usize, 0);
        behind.extend_from_slice(bytes);
        self.place.write_at(&behind, self.end + self.provisional)?;
        self.place.sync()?;
        self.place.write_at(&private_header(copy - self.end - HEADER), self.end)?;
        self.place.sync()?;
        // The file is now whole up to the end of the copy.
        self.provisional = copy + length - self.end;
        let to_the_end = private_header(copy - self.end - HEADER);
        self.place.write_at(&[&bytes[HEADER as usize..], &to_the_end].concat(), self.end + HEADER)?;
        self.place.sync()?;
        self.place.write_at(&bytes[..HEADER as usize], self.end)?;
        self.place.sync()?;
        self.end += length;
        self.provisional = 0;
        self.place.truncate(self.end)
    }

    /// Adds bytes to the provisional part.
    pub(crate) fn extend_provisionally(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.place.write_at(bytes, self.end + self.provisional)?;
        self.provisional += bytes.len() as u64;
        Ok(())
    }

    /// Waits until everything is safe from a power failure.
    pub(crate) fn sync(&mut self) -> io::Result<()> {
        self.place.sync()
    }

    /// Cuts off all but the first `length` bytes, which are final.
    pub(crate) fn cut_to(&mut self, length: u64) -> io::Result<()> {
        (self.end, self.provisional) = (length, 0);
        self.place.truncate(length)
    }

    /// The end of the whole part of the file.
    pub(crate) fn whole(&self) -> u64 {
        self.end + self.provisional
    }

    /// Cuts off what a write that failed has left, and of the provisional part the last `length` bytes.
    pub(crate) fn cut(&mut self, length: u64) -> io::Result<()> {
        self.provisional -= length.min(self.provisional);
        self.place.truncate(self.whole())
    }

    /// Ends the file behind its whole part, after a write that failed: a complete log, but without a summary.
    pub(crate) fn end_short(&mut self) -> io::Result<()> {
        let whole = self.end + self.provisional;
        self.place.truncate(whole)?;
        self.place.write_at(&SHORT_END, whole)?;
        self.place.sync()
    }
}

fn private_header(length: u64) -> [u8; HEADER as usize] {
    let mut header = [PRIVATE; HEADER as usize];
    header[1..].copy_from_slice(&length.to_le_bytes());
    header
}

#[cfg(test)]
mod tests {
    use super::*;
    use mcap::WriteOptions;
    use std::collections::BTreeMap;
    use std::io::Cursor;

    /// Every change that was made.
    #[derive(Default)]
    struct History(Vec<Change>);

    enum Change {
        Write(Vec<u8>, u64),
        Truncate(u64),
    }

    impl Place for History {
        fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()> {
            self.0.push(Change::Write(bytes.to_vec(), offset));
            Ok(())
        }

        fn truncate(&mut self, length: u64) -> io::Result<()> {
            self.0.push(Change::Truncate(length));
            Ok(())
        }

        fn sync(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn write(file: &mut Vec<u8>, bytes: &[u8], offset: u64) {
        let offset = offset as usize;
        file.resize(file.len().max(offset + bytes.len()), 0);
        file[offset..offset + bytes.len()].copy_from_slice(bytes);
    }

    /// The bytes of a log with one channel, and of chunks with the messages of the ranges.
    fn parts(chunks: &[std::ops::Range<u64>]) -> (Vec<u8>, Vec<Vec<u8>>) {
        let mut writer = WriteOptions::new()
            .chunk_size(None)
            .compression(None)
            .disable_seeking(true)
            .create(Cursor::new(Vec::new()))
            .expect("memory");
        let schema = writer.add_schema("s", "ros2msg", b"string data").expect("memory");
        let channel_id = writer.add_channel(schema, "/t", "cdr", &BTreeMap::new()).expect("memory");
        writer.flush().expect("memory");
        let mut lengths = Vec::new();
        for chunk in chunks {
            for time in chunk.clone() {
                let header =
                    mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
                writer.write_to_known_channel(&header, &[time as u8; 40]).expect("memory");
            }
            writer.flush().expect("memory");
            lengths.push(());
        }
        let bytes = writer.into_inner().into_inner();
        // A chunk starts at every record of the kind 6.
        let (mut starts, mut at) = (Vec::new(), 8);
        while at < bytes.len() {
            if bytes[at] == 6 {
                starts.push(at);
            }
            at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight")) as usize;
        }
        starts.push(bytes.len());
        assert_eq!(starts.len(), lengths.len() + 2);
        (bytes[..starts[1]].to_vec(), starts[1..].windows(2).map(|pair| bytes[pair[0]..pair[1]].to_vec()).collect())
    }

    fn times(file: &[u8]) -> Vec<u64> {
        let Ok(stream) = mcap::MessageStream::new_with_options(file, mcap::read::Options::IgnoreEndMagic.into()) else {
            return Vec::new();
        };
        stream.map_while(Result::ok).map(|message| message.log_time).collect()
    }

    /// Three provisional chunks, the last of which also has messages that were not saved before; then the final one.
    #[test]
    fn wherever_a_write_is_cut_short_no_message_that_was_saved_is_lost_or_read_twice() {
        // The final chunk may be smaller than the provisional ones together, and larger.
        for last in [0..12, 0..400] {
            let (start, chunks) = parts(&[0..4, 4..8, 8..12, last.clone()]);
            let mut tail = Tail::new(History::default());
            tail.extend(&start).expect("memory");
            for chunk in &chunks[..3] {
                tail.extend_provisionally(chunk).expect("memory");
            }
            tail.extend(&chunks[3]).expect("memory");
            let (mut file, mut least) = (Vec::new(), 0);
            for (number, change) in tail.place.0.iter().enumerate() {
                match change {
                    // The header that switches is one write of a few bytes and counts as done or not done.
                    Change::Write(bytes, offset) => {
                        let cuts = if bytes.len() == 9 { 0..1 } else { 0..bytes.len() };
                        for cut in cuts {
                            let mut torn = file.clone();
                            write(&mut torn, &bytes[..cut], *offset);
                            let times = times(&torn);
                            assert!(times.len() >= least, "change {number}, cut {cut}: {} of {least}", times.len());
                            assert!(
                                times.iter().copied().eq(0..times.len() as u64),
                                "change {number}, cut {cut}: {times:?}"
                            );
                        }
                        write(&mut file, bytes, *offset);
                    }
                    Change::Truncate(length) => file.truncate(*length as usize),
                }
                least = times(&file).len();
                assert_eq!(
                    least,
                    [0, 4, 8, 12, 12, last.end as usize, last.end as usize, last.end as usize, last.end as usize]
                        [number],
                    "{number}"
                );
            }
            assert_eq!(file, [start, chunks[3].clone()].concat());
        }
    }

    #[test]
    fn a_log_that_was_ended_short_is_complete() {
        let (start, chunks) = parts(&[0..4, 4..8]);
        let mut tail = Tail::new(History::default());
        tail.extend(&start).expect("memory");
        tail.extend_provisionally(&chunks[0]).expect("memory");
        tail.end_short().expect("memory");
        let mut file = Vec::new();
        for change in &tail.place.0 {
            if let Change::Write(bytes, offset) = change {
                write(&mut file, bytes, *offset);
            }
        }
        let messages: Result<Vec<_>, _> = mcap::MessageStream::new(&file).expect("complete").collect();
        assert_eq!(messages.expect("every message is readable").len(), 4);
    }
}

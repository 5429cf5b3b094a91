//! Bytes that may still change, before they go into a pipe or device: if the run may begin again, all bytes until its end.
//!
//! ```text
//!     run ─▶ spool: in memory up to 8 MiB, then an unnamed temporary file ─▶ at the end of the run ─▶ pipe
//! ```
//!
//! The temporary file has a name for the instant in which it is made. So it disappears however the process ends.

use crate::output::log::storage::place::{FilePlace, Place};
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

/// Most bytes in memory; the temporary file takes the rest.
const MOST_IN_MEMORY: u64 = 8 << 20;

/// Bytes that are handed on at once: less than a pipe takes.
const PIECE: usize = 1 << 14;

/// Bytes at offsets, in memory or in a file.
#[derive(Default)]
pub(crate) struct Spool {
    memory: Vec<u8>,
    /// Holds all of them once there are many.
    file: Option<FilePlace>,
    length: u64,
}

impl Place for Spool {
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()> {
        let end = offset + bytes.len() as u64;
        if self.file.is_none() && end > MOST_IN_MEMORY {
            let mut file = FilePlace::new(unnamed(&std::env::temp_dir())?, true);
            file.write_at(&self.memory, 0).map_err(held_back)?;
            self.file = Some(file);
            self.memory = Vec::new();
        }
        match &mut self.file {
            Some(file) => file.write_at(bytes, offset).map_err(held_back)?,
            None => {
                let length = self.memory.len().max(end as usize);
                self.memory.resize(length, 0);
                self.memory[offset as usize..end as usize].copy_from_slice(bytes);
            }
        }
        self.length = self.length.max(end);
        Ok(())
    }

    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.length = self.length.min(length);
        self.memory.truncate(length as usize);
        self.file.as_mut().map_or(Ok(()), |file| file.truncate(length))
    }

    /// A power failure loses bytes that no reader has seen.
    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Spool {
    /// Hands all bytes on in order, in pieces.
    pub(crate) fn pour(mut self, mut take: impl FnMut(&[u8]) -> io::Result<()>) -> io::Result<()> {
        let Some(file) = self.file.take() else { return self.memory.chunks(PIECE).try_for_each(take) };
        let mut file = file.into_file();
        file.seek(SeekFrom::Start(0)).map_err(held_back)?;
        let mut piece = vec![0; PIECE];
        let mut left = self.length;
        while left > 0 {
            let wanted = left.min(PIECE as u64) as usize;
            file.read_exact(&mut piece[..wanted]).map_err(held_back)?;
            take(&piece[..wanted])?;
            left -= wanted as u64;
        }
        Ok(())
    }
}

/// The destination of the bytes of a log: its file, pipe or device, or a spool until the run has ended.
pub(crate) struct LogPlace {
    file: FilePlace,
    /// The length that is in the pipe for good, and the bytes after it.
    held: Option<(u64, Spool)>,
}

impl LogPlace {
    pub(crate) fn new(file: FilePlace) -> Self {
        LogPlace { file, held: None }
    }

    /// Holds back everything from this offset on.
    pub(crate) fn hold(&mut self, from: u64) {
        self.held = Some((from, Spool::default()));
    }

    /// Whether bytes are held back.
    pub(crate) fn holds(&self) -> bool {
        self.held.is_some()
    }

    /// Hands on the bytes that were held back, and stops holding them back. `went_on` is called after every piece that was taken.
    pub(crate) fn release(&mut self, went_on: &dyn Fn()) -> io::Result<()> {
        let Some((mut at, spool)) = self.held.take() else { return Ok(()) };
        spool.pour(|piece| {
            self.file.write_at(piece, at)?;
            at += piece.len() as u64;
            went_on();
            Ok(())
        })
    }
}

impl Place for LogPlace {
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()> {
        match &mut self.held {
            Some((from, spool)) => spool.write_at(bytes, offset.saturating_sub(*from)),
            None => self.file.write_at(bytes, offset),
        }
    }

    fn truncate(&mut self, length: u64) -> io::Result<()> {
        match &mut self.held {
            Some((from, spool)) => spool.truncate(length.saturating_sub(*from)),
            None => self.file.truncate(length),
        }
    }

    fn sync(&mut self) -> io::Result<()> {
        self.held.as_mut().map_or_else(|| self.file.sync(), |(_, spool)| spool.sync())
    }
}

/// A new file without a name in a folder.
fn unnamed(folder: &Path) -> io::Result<File> {
    static MADE: AtomicU32 = AtomicU32::new(0);
    let name = format!("catena-{}-{}.spool", std::process::id(), MADE.fetch_add(1, Ordering::Relaxed));
    let path = folder.join(name);
    let file = OpenOptions::new().read(true).write(true).create_new(true).open(&path).map_err(held_back)?;
    std::fs::remove_file(&path).map_err(held_back)?;
    Ok(file)
}

/// Says that it was not the pipe that failed.
fn held_back(error: io::Error) -> io::Error {
    let folder = std::env::temp_dir();
    let what =
        format!("the log is held back in {} until the run has ended, and that failed: {error}", folder.display());
    io::Error::new(error.kind(), what)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poured(spool: Spool) -> Vec<u8> {
        let mut all = Vec::new();
        spool
            .pour(|piece| {
                assert!(piece.len() <= PIECE);
                all.extend_from_slice(piece);
                Ok(())
            })
            .expect("memory");
        all
    }

    /// Bytes that tell their places.
    fn bytes(from: u64, count: usize) -> Vec<u8> {
        (from..from + count as u64).map(|at| (at % 251) as u8).collect()
    }

    #[test]
    fn what_was_written_last_comes_out_from_memory_and_from_a_file_and_what_was_cut_off_does_not() {
        for blocks in [3, 40] {
            let (mut spool, block) = (Spool::default(), 300_000);
            for number in 0..blocks {
                let at = number as u64 * block as u64;
                spool.write_at(&vec![7; block], at).expect("written");
            }
            assert_eq!(spool.file.is_some(), blocks as u64 * block as u64 > MOST_IN_MEMORY);
            spool.truncate(100).expect("cut");
            for number in 0..blocks {
                let at = number as u64 * block as u64;
                spool.write_at(&bytes(at, block), at).expect("written");
            }
            spool.write_at(&bytes(10, 5), 10).expect("written over");
            let last = (blocks * block - 1000) as u64;
            spool.truncate(last).expect("cut");
            assert!(poured(spool) == bytes(0, last as usize), "{blocks} blocks");
        }
    }

    #[test]
    fn a_temporary_file_leaves_no_name_and_a_folder_that_is_missing_is_an_error_that_names_the_cause() {
        let folder = std::env::temp_dir().join(format!("catena-spool-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let held = unnamed(&folder).expect("a file");
        assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 0);
        drop(held);
        std::fs::remove_dir(&folder).expect("removed");
        let error = unnamed(&folder).expect_err("no folder").to_string();
        assert!(error.contains("held back"), "{error}");
    }
}

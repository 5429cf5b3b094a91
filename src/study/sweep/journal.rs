//! The rows of a file that is not complete, in the order of their completion, so that no row is lost.
//!
//! ```text
//!     record:  length of the row (u32), its CRC-32 (u32), the row         little endian
//! ```
//!
//! A record that was cut off, by a kill or a full disk, ends the reading; it is cut off the file before anything is added.

use crate::sweep::error::SweepError;
use crate::sweep::rows::Row;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file that rows are added to.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    /// Bytes that have not been written yet.
    pending: Vec<u8>,
    row: Vec<u8>,
}

impl Journal {
    /// Opens or makes a journal: the rows of these indices that it holds, with this number of columns.
    pub fn open(path: &Path, indices: &Range<u64>, columns: usize) -> Result<(Self, Vec<Row>), SweepError> {
        let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let mut file = opened.map_err(|error| SweepError::write(path, &error))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(|error| SweepError::read(path, &error))?;
        let (mut rows, mut whole) = (Vec::<Row>::new(), 0);
        while let Some((row, length)) = record(&bytes[whole..]) {
            if row.cells.len() != columns || !indices.contains(&row.index) {
                break;
            }
            whole += length;
            rows.push(row);
        }
        let cut = file.set_len(whole as u64).and_then(|()| file.seek(SeekFrom::End(0)));
        cut.map_err(|error| SweepError::write(path, &error))?;
        Ok((Journal { path: path.to_path_buf(), file, pending: Vec::new(), row: Vec::new() }, rows))
    }

    /// Adds a row, which is not on the disk before [`Journal::sync`].
    pub fn add(&mut self, row: &Row) {
        self.row.clear();
        row.encode(&mut self.row);
        self.pending.extend((self.row.len() as u32).to_le_bytes());
        self.pending.extend(crc32fast::hash(&self.row).to_le_bytes());
        self.pending.extend(&self.row);
    }

    /// Whether there are rows that are not on the disk.
    pub fn is_behind(&self) -> bool {
        !self.pending.is_empty()
    }

    /// Puts all rows on the disk.
    pub fn sync(&mut self) -> Result<(), SweepError> {
        let written = self.file.write_all(&self.pending).and_then(|()| self.file.sync_data());
        self.pending.clear();
        written.map_err(|error| SweepError::write(&self.path, &error))
    }

    /// Removes the file, whose rows are elsewhere.
    pub fn remove(self) -> Result<(), SweepError> {
        std::fs::remove_file(&self.path).map_err(|error| SweepError::write(&self.path, &error))
    }
}

/// The first record, and how long it is.
fn record(bytes: &[u8]) -> Option<(Row, usize)> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    let (sum, rest) = rest.split_first_chunk::<4>()?;
    let length = u32::from_le_bytes(*length) as usize;
    let row = rest.get(..length)?;
    (crc32fast::hash(row) == u32::from_le_bytes(*sum)).then_some(())?;
    Some((Row::decode(row)?, 8 + length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::rows::Cell;

    fn row(index: u64) -> Row {
        Row { index, failed: false, cells: vec![Cell::Count(index), Cell::Number(0.1 * index as f64)] }
    }

    #[test]
    fn wherever_a_journal_is_cut_off_the_rows_before_are_read_and_others_can_follow() {
        let path = std::env::temp_dir().join(format!("catena_journal_{}", std::process::id()));
        let (mut journal, none) = Journal::open(&path, &(0..10), 2).unwrap();
        assert!(none.is_empty());
        [4, 2, 7].iter().for_each(|&index| journal.add(&row(index)));
        journal.sync().unwrap();
        drop(journal);
        let whole = std::fs::read(&path).unwrap();
        let length = whole.len() / 3;
        for cut in 0..=whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            let (mut journal, rows) = Journal::open(&path, &(0..10), 2).unwrap();
            let kept = cut / length;
            assert_eq!(rows, [4, 2, 7][..kept].iter().map(|&index| row(index)).collect::<Vec<_>>(), "cut at {cut}");
            journal.add(&row(9));
            journal.sync().unwrap();
            drop(journal);
            let (_, rows) = Journal::open(&path, &(0..10), 2).unwrap();
            assert_eq!((rows.len(), &rows[kept]), (kept + 1, &row(9)), "cut at {cut}");
        }
        // A byte that differs from the written one ends the reading, too.
        let mut spoilt = whole.clone();
        spoilt[length + 12] ^= 1;
        std::fs::write(&path, &spoilt).unwrap();
        assert_eq!(Journal::open(&path, &(0..10), 2).unwrap().1, [row(4)]);
        std::fs::remove_file(&path).unwrap();
    }
}

//! The folder of a sweep: the rows on the disk, and how new ones are added.
//!
//! A row is counted as done when its journal is on the disk. When all rows of a file are there, the file is written in the order of the index, and
//! then the journal is removed: a kill at any instant leaves one of the two.

use crate::sweep::definition::Sweep;
use crate::sweep::error::SweepError;
use crate::sweep::index_ranges::{Shard, files};
use crate::sweep::journal::Journal;
use crate::sweep::manifest::{Format, MANIFEST, Manifest, name};
use crate::sweep::one_run::headings;
use crate::sweep::rows::Row;
use crate::sweep::whole_file::sync_folder;
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::ops::Range;
use std::path::{Path, PathBuf};

const LOCK: &str = "sweep.lock";

/// A file that is not complete.
struct Open {
    range: Range<u64>,
    rows: Vec<Row>,
    journal: Journal,
}

/// The folder of a sweep, or of one of its shards.
pub struct Folder {
    path: PathBuf,
    manifest: Manifest,
    /// Indices of the shard.
    range: Range<u64>,
    open: BTreeMap<u64, Open>,
    /// First indices of the files that are complete.
    complete: std::collections::HashSet<u64>,
    done: u64,
    /// Held for as long as this lives.
    _lock: File,
}

impl Folder {
    /// Opens the folder of a sweep to go on with it, or makes it.
    ///
    /// # Errors
    /// [`SweepError::Folder`] if it is of something else or another process writes to it; [`SweepError::Disk`] if it cannot be written.
    pub fn open(path: &Path, sweep: &Sweep, shard: Shard, format: Format) -> Result<Self, SweepError> {
        let manifest = Manifest {
            catena: env!("CARGO_PKG_VERSION").to_string(),
            sweep: sweep.name.clone(),
            fingerprint: sweep.fingerprint.clone(),
            runs: sweep.runs,
            shard: shard.numbers(),
            rows_per_file: sweep.rows_per_file,
            format,
            columns: headings(sweep),
        };
        let lock = prepare(path)?;
        match Manifest::read(path)? {
            None => {
                refuse_foreign(path)?;
                manifest.write(path)?;
            }
            Some(there) => refuse_other(path, &there, &manifest)?,
        }
        let mut folder = Folder {
            path: path.to_path_buf(),
            range: shard.range(sweep.runs),
            manifest,
            open: BTreeMap::new(),
            complete: Default::default(),
            done: 0,
            _lock: lock,
        };
        for range in files(folder.range.clone(), folder.manifest.rows_per_file) {
            if folder.manifest.file(path, &range).exists() {
                folder.done += range.end - range.start;
                folder.complete.insert(range.start);
                // A kill between the two leaves it.
                let _ = std::fs::remove_file(folder.journal(&range));
            } else if folder.journal(&range).exists() {
                let rows = folder.opened(&range)?.rows.len() as u64;
                folder.done += rows;
            }
        }
        folder.finish_files()?;
        Ok(folder)
    }

    fn journal(&self, range: &Range<u64>) -> PathBuf {
        self.path.join(name(range, "journal"))
    }

    /// The file of some rows, which is not complete.
    fn opened(&mut self, range: &Range<u64>) -> Result<&mut Open, SweepError> {
        if !self.open.contains_key(&range.start) {
            let path = self.journal(range);
            let is_new = !path.exists();
            let (journal, read) = Journal::open(&path, range, self.manifest.columns.len())?;
            if is_new {
                sync_folder(&path).map_err(|error| SweepError::write(&path, &error))?;
            }
            let mut rows: Vec<Row> = Vec::with_capacity(read.len());
            let mut seen = std::collections::HashSet::new();
            rows.extend(read.into_iter().filter(|row| seen.insert(row.index)));
            self.open.insert(range.start, Open { range: range.clone(), rows, journal });
        }
        // It was put there.
        self.open.get_mut(&range.start).ok_or_else(|| SweepError::folder(Path::new(""), "it changed"))
    }

    /// How many rows are on the disk.
    pub fn done(&self) -> u64 {
        self.done
    }

    /// How many rows there will be.
    pub fn runs(&self) -> u64 {
        self.range.end - self.range.start
    }

    /// The indices of runs that are still to be made, in their order.
    pub fn pending(&self) -> Vec<Range<u64>> {
        let mut pending: Vec<Range<u64>> = Vec::new();
        for file in files(self.range.clone(), self.manifest.rows_per_file) {
            if self.complete.contains(&file.start) {
                continue;
            }
            let mut there: Vec<u64> =
                self.open.get(&file.start).map_or(Vec::new(), |open| open.rows.iter().map(|row| row.index).collect());
            there.sort_unstable();
            let mut first = file.start;
            for index in there.into_iter().chain([file.end]) {
                if first < index {
                    pending.push(first..index);
                }
                first = index + 1;
            }
        }
        pending
    }

    /// Takes a row, which is not done before [`Folder::commit`].
    pub(super) fn add(&mut self, row: Row) -> Result<(), SweepError> {
        let size = self.manifest.rows_per_file;
        let start = (row.index / size * size).max(self.range.start);
        let end = ((row.index / size + 1) * size).min(self.range.end);
        let open = self.opened(&(start..end))?;
        open.journal.add(&row);
        open.rows.push(row);
        Ok(())
    }

    /// Puts all rows on the disk, and counts them as done.
    pub(super) fn commit(&mut self) -> Result<(), SweepError> {
        for open in self.open.values_mut().filter(|open| open.journal.is_behind()) {
            open.journal.sync()?;
        }
        let complete: u64 = self.complete.len() as u64;
        self.finish_files()?;
        // Files that were finished before are counted; those that were now, and the open ones, are counted anew.
        if complete != self.complete.len() as u64 || !self.open.is_empty() {
            self.done = self.count();
        }
        Ok(())
    }

    fn count(&self) -> u64 {
        let size = self.manifest.rows_per_file;
        let rows = |start: &u64| ((start / size + 1) * size).min(self.range.end) - start;
        self.complete.iter().map(rows).sum::<u64>() + self.open.values().map(|open| open.rows.len() as u64).sum::<u64>()
    }

    /// Writes the files of which all rows are there.
    fn finish_files(&mut self) -> Result<(), SweepError> {
        let full = |open: &Open| open.rows.len() as u64 == open.range.end - open.range.start;
        let starts: Vec<u64> = self.open.iter().filter(|(_, open)| full(open)).map(|(&start, _)| start).collect();
        for start in starts {
            let Some(mut open) = self.open.remove(&start) else { continue };
            open.rows.sort_unstable_by_key(|row| row.index);
            let path = self.manifest.file(&self.path, &open.range);
            self.manifest.format.write(&path, &self.manifest.columns, &open.rows)?;
            open.journal.remove()?;
            self.complete.insert(start);
        }
        Ok(())
    }

    /// The pattern of its complete files, for people.
    pub fn files(&self) -> String {
        self.path.join(format!("rows-*.{}", self.manifest.format.name())).display().to_string()
    }
}

/// Makes the folder if it does not exist, and locks it.
pub(super) fn prepare(path: &Path) -> Result<File, SweepError> {
    if path.exists() && !path.is_dir() {
        return Err(SweepError::folder(path, "it is not a folder"));
    }
    if !path.exists() {
        let made = std::fs::create_dir_all(path).and_then(|()| sync_folder(path));
        made.map_err(|error| SweepError::folder(path, error.to_string()))?;
    }
    let lock = path.join(LOCK);
    // Files of the folder stay untouched until it is known to belong to a sweep.
    if !lock.exists() && !path.join(MANIFEST).exists() {
        refuse_foreign(path)?;
    }
    let file = File::options()
        .write(true)
        .create(true)
        .truncate(false)
        .open(&lock)
        .map_err(|error| SweepError::write(&lock, &error))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            Err(SweepError::folder(path, "another process writes to it; wait for its end, or give another folder"))
        }
        // Some file systems know no locks.
        Err(TryLockError::Error(_)) | Ok(()) => Ok(file),
    }
}

/// Refuses a folder with files of something else.
fn refuse_foreign(path: &Path) -> Result<(), SweepError> {
    let entries = std::fs::read_dir(path).map_err(|error| SweepError::read(path, &error))?;
    let foreign = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let ours = |name: &str| name == LOCK || name.starts_with(MANIFEST);
    match foreign.into_iter().find(|name| !ours(name)) {
        Some(name) => {
            Err(SweepError::folder(path, format!("it holds {name:?} and is of no sweep; give a new or empty folder")))
        }
        None => Ok(()),
    }
}

/// Refuses a folder of another sweep.
fn refuse_other(path: &Path, there: &Manifest, wanted: &Manifest) -> Result<(), SweepError> {
    let otherwise = "remove it, or give another folder";
    let reason = if there.fingerprint != wanted.fingerprint
        || there.columns != wanted.columns
        || there.runs != wanted.runs
    {
        format!(
            "it holds the sweep {:?} of other numbers, another scene or another version of catena ({}); {otherwise}",
            there.sweep, there.catena
        )
    } else if there.shard != wanted.shard {
        let ((number, of), (own, own_of)) = (there.shard, wanted.shard);
        format!("it holds shard {number}/{of} of this sweep, and {own}/{own_of} is wanted; {otherwise}")
    } else if there.format != wanted.format {
        format!("its rows are {}; give --format {0}, or another folder", there.format.name())
    } else if there.rows_per_file != wanted.rows_per_file {
        format!("its files have {} rows; {otherwise}", there.rows_per_file)
    } else {
        return Ok(());
    };
    Err(SweepError::folder(path, reason))
}

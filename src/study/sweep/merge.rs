//! The folders of all shards as one, with the files that the whole sweep would have written.

use crate::sweep::error::SweepError;
use crate::sweep::folder::prepare;
use crate::sweep::index_ranges::{Shard, files};
use crate::sweep::manifest::{Format, Manifest};
use crate::sweep::whole_file::whole;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file of rows of a shard.
struct Part {
    path: PathBuf,
    rows: Range<u64>,
}

/// Merges the folders of all shards of a sweep into one; says how many rows and files there are.
///
/// # Errors
/// [`SweepError::Folder`] for folders of different sweeps, shards that are missing or given twice, and shards that are not complete;
/// [`SweepError::Disk`].
pub fn merge(folders: &[PathBuf], out: &Path) -> Result<(u64, usize), SweepError> {
    let mut shards: Vec<(Manifest, &Path)> = Vec::with_capacity(folders.len());
    for folder in folders {
        match Manifest::read(folder)? {
            Some(manifest) => shards.push((manifest, folder)),
            None => return Err(SweepError::folder(folder, "it is of no sweep: there is no sweep.json")),
        }
    }
    let Some(first) = shards.first().map(|(manifest, _)| manifest.clone()) else { return Ok((0, 0)) };
    shards.sort_by_key(|(manifest, _)| manifest.shard.0);
    let of = first.shard.1;
    for (manifest, folder) in &shards {
        if (Manifest { shard: first.shard, ..manifest.clone() }) != first {
            return Err(SweepError::folder(folder, "it is of another sweep, version or format than the first folder"));
        }
        if manifest.shard.1 != of {
            return Err(SweepError::folder(
                folder,
                format!("it is one of {} shards, and the first folder one of {of}", manifest.shard.1),
            ));
        }
    }
    for number in 1..=of {
        let mut here = shards.iter().filter(|(manifest, _)| manifest.shard.0 == number);
        match (here.next(), here.next()) {
            (None, _) => {
                return Err(SweepError::folder(out, format!("shard {number}/{of} is missing; give its folder, too")));
            }
            (Some(_), Some((_, folder))) => {
                return Err(SweepError::folder(folder, format!("shard {number}/{of} is given twice")));
            }
            (Some(_), None) => {}
        }
    }
    let mut parts = Vec::new();
    for (manifest, folder) in &shards {
        let shard = format!("{}/{of}", manifest.shard.0);
        let range = shard.parse().map_or(0..0, |shard: Shard| shard.range(manifest.runs));
        for rows in files(range, manifest.rows_per_file) {
            let path = manifest.file(folder, &rows);
            if !path.exists() {
                let reason = format!("shard {shard} is not complete: there is no {}; run it again", path.display());
                return Err(SweepError::folder(folder, reason));
            }
            parts.push(Part { path, rows });
        }
    }
    let _lock = prepare(out)?;
    let whole = Manifest { shard: (1, 1), ..first };
    match Manifest::read(out)? {
        Some(there) if there != whole => {
            return Err(SweepError::folder(out, "it holds another sweep; give a new folder"));
        }
        Some(_) => {}
        None => whole.write(out)?,
    }
    let mut parts = parts.into_iter().peekable();
    let mut count = 0;
    for rows in files(0..whole.runs, whole.rows_per_file) {
        let here: Vec<Part> = std::iter::from_fn(|| parts.next_if(|part| part.rows.end <= rows.end)).collect();
        let path = whole.file(out, &rows);
        join(&here, &path, &whole)?;
        count += 1;
    }
    Ok((whole.runs, count))
}

/// Writes the rows of some files into one.
fn join(parts: &[Part], out: &Path, manifest: &Manifest) -> Result<(), SweepError> {
    match manifest.format {
        Format::Csv => whole(out, |out| {
            for (number, part) in parts.iter().enumerate() {
                let mut lines = BufReader::new(File::open(&part.path)?);
                // Names are in the first line of each; they hold no ends of lines, as no row does.
                let mut names = Vec::new();
                lines.read_until(b'\n', &mut names)?;
                if number == 0 {
                    out.write_all(&names)?;
                }
                std::io::copy(&mut lines, out)?;
            }
            Ok(())
        }),
        #[cfg(feature = "parquet")]
        Format::Parquet => {
            let mut rows = Vec::new();
            for part in parts {
                let read = crate::sweep::rows_parquet::read(&part.path, &manifest.columns);
                rows.extend(read.map_err(|error| SweepError::read(&part.path, &error))?);
            }
            Format::Parquet.write(out, &manifest.columns, &rows)
        }
        #[cfg(not(feature = "parquet"))]
        Format::Parquet => Format::Parquet.write(out, &manifest.columns, &[]),
    }
}

//! The manifest of a folder: the sweep it belongs to, and the names and format of its files of rows.

use crate::sweep::error::SweepError;
use crate::sweep::rows::{Heading, Row};
use crate::sweep::rows_csv;
use crate::sweep::whole_file::whole;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The file that says to which sweep a folder belongs.
pub(super) const MANIFEST: &str = "sweep.json";

/// How rows are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// As text.
    Csv,
    /// As Apache Parquet, where the feature `parquet` is compiled in.
    Parquet,
}

/// There is no such format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownFormat {
    /// Neither of them.
    #[error("{0:?} is neither csv nor parquet")]
    Name(String),
    /// Not in this build.
    #[error(
        "this catena was built without Parquet; build it with `cargo build --release --features parquet`, or give csv"
    )]
    NotBuilt,
}

impl Format {
    /// Parquet where it is compiled in, and CSV elsewhere.
    pub const DEFAULT: Format = if cfg!(feature = "parquet") { Format::Parquet } else { Format::Csv };

    /// The name, which files end with.
    pub fn name(self) -> &'static str {
        match self {
            Format::Csv => "csv",
            Format::Parquet => "parquet",
        }
    }

    /// Writes a file of rows.
    pub(super) fn write(self, path: &Path, headings: &[Heading], rows: &[Row]) -> Result<(), SweepError> {
        whole(path, |out| self.put(headings, rows, out))
    }

    /// The number of bytes of a file of rows; zero if it cannot be written.
    pub(super) fn size(self, headings: &[Heading], rows: &[Row]) -> usize {
        let mut bytes = Vec::new();
        self.put(headings, rows, &mut bytes).map_or(0, |()| bytes.len())
    }

    fn put(self, headings: &[Heading], rows: &[Row], out: &mut (impl Write + Send)) -> io::Result<()> {
        match self {
            Format::Csv => {
                rows_csv::heading(headings, out)?;
                rows.iter().try_for_each(|row| rows_csv::row(row, out))
            }
            #[cfg(feature = "parquet")]
            Format::Parquet => crate::sweep::rows_parquet::write(headings, rows, out),
            #[cfg(not(feature = "parquet"))]
            Format::Parquet => Err(io::Error::other(UnknownFormat::NotBuilt)),
        }
    }
}

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        match name {
            "csv" => Ok(Format::Csv),
            "parquet" if cfg!(feature = "parquet") => Ok(Format::Parquet),
            "parquet" => Err(UnknownFormat::NotBuilt),
            other => Err(UnknownFormat::Name(other.to_string())),
        }
    }
}

/// The content of `sweep.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Manifest {
    pub catena: String,
    pub sweep: String,
    pub fingerprint: String,
    pub runs: u64,
    /// Number, from 1, and count.
    pub shard: (u64, u64),
    pub rows_per_file: u64,
    pub format: Format,
    pub columns: Vec<Heading>,
}

impl Manifest {
    /// The manifest of a folder; `None` if it has no manifest.
    pub fn read(folder: &Path) -> Result<Option<Self>, SweepError> {
        let path = folder.join(MANIFEST);
        match std::fs::read(&path) {
            Ok(bytes) => match serde_json::from_slice(&bytes) {
                Ok(manifest) => Ok(Some(manifest)),
                Err(error) => Err(SweepError::folder(
                    folder,
                    format!("{MANIFEST} is none of a sweep of this version ({error}); give another folder"),
                )),
            },
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(SweepError::read(&path, &error)),
        }
    }

    pub fn write(&self, folder: &Path) -> Result<(), SweepError> {
        whole(&folder.join(MANIFEST), |out| {
            serde_json::to_writer_pretty(&mut *out, self)?;
            out.write_all(b"\n")
        })
    }

    /// The file of some rows.
    pub fn file(&self, folder: &Path, rows: &Range<u64>) -> PathBuf {
        folder.join(name(rows, self.format.name()))
    }
}

/// The name of a file of these rows. Indices have as many digits as 10¹⁶ − 1, so that names are in the order of rows.
pub(super) fn name(rows: &Range<u64>, ending: &str) -> String {
    format!("rows-{:016}-{:016}.{ending}", rows.start, rows.end - 1)
}

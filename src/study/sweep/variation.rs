//! The varied numbers of a run, from its index.
//!
//! Grids and lists multiply; `samples` runs are made at each of their points. The index counts like the digits of a number, the sample last:
//!
//! ```text
//!     index = (…(d₁ n₂ + d₂) n₃ + …) · samples + sample          0 ≤ dᵢ < nᵢ
//! ```

use crate::scene::Parameter;
use crate::sweep::random::{Law, Place};

/// A number that varies.
#[derive(Clone, Debug)]
pub(crate) struct Column {
    pub parameter: Parameter,
    /// The numbers of the sweep file are multiples of this unit.
    pub unit: f64,
}

/// The source of the numbers of some columns.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    /// A number of a list, the same for all of its columns.
    Grid { first: usize, columns: usize, values: Vec<f64> },
    /// A row of a table, one number for each of its columns.
    Table { first: usize, columns: usize, rows: Vec<f64> },
    /// A number that is drawn, the same for all of its columns.
    Random { first: usize, columns: usize, law: Law, entry: u64 },
}

/// All numbers that vary.
#[derive(Clone, Debug)]
pub(crate) struct Variation {
    pub columns: Vec<Column>,
    /// In the order of the sweep file.
    pub sources: Vec<Source>,
    pub seed: u64,
    /// Runs at each point of grids and tables.
    pub samples: u64,
}

impl Source {
    /// The number of values or rows; `None` for random draws.
    fn count(&self) -> Option<u64> {
        match self {
            Source::Grid { values, .. } => Some(values.len() as u64),
            Source::Table { rows, columns, .. } => Some((rows.len() / columns) as u64),
            Source::Random { .. } => None,
        }
    }
}

impl Variation {
    /// How many runs there are; `None` if they cannot be counted.
    pub fn runs(&self) -> Option<u64> {
        self.sources.iter().filter_map(Source::count).try_fold(self.samples, u64::checked_mul)
    }

    /// The numbers of a run, column by column.
    pub fn numbers(&self, index: u64, out: &mut Vec<f64>) {
        out.clear();
        out.resize(self.columns.len(), 0.0);
        let mut rest = index / self.samples;
        for source in self.sources.iter().rev() {
            let digit = source.count().map_or(0, |count| {
                let digit = (rest % count) as usize;
                rest /= count;
                digit
            });
            match source {
                Source::Grid { first, columns, values } => out[*first..first + columns].fill(values[digit]),
                Source::Table { first, columns, rows } => {
                    out[*first..first + columns].copy_from_slice(&rows[digit * columns..(digit + 1) * columns]);
                }
                Source::Random { first, columns, law, entry } => {
                    out[*first..first + columns].fill(law.draw(Place { seed: self.seed, index, entry: *entry }));
                }
            }
        }
        for (number, column) in out.iter_mut().zip(&self.columns) {
            *number *= column.unit;
        }
    }
}

//! Estimates the cost of a sweep: a few runs, spread over its indices, are made and timed, and no rows are written.

use crate::simulation::parallel::threads::on_one_thread;
use crate::sweep::definition::Sweep;
use crate::sweep::error::SweepError;
use crate::sweep::index_ranges::{Shard, files};
use crate::sweep::manifest::Format;
use crate::sweep::one_run::{Runner, headings};
use crate::sweep::rows::Row;
use cpu_time::ThreadTime;
use serde::Serialize;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// No run begins after this time.
const LONG_ENOUGH: Duration = Duration::from_secs(2);

/// Most runs that are made.
const MOST: u64 = 1000;

/// The estimated time and space of a sweep, or of its shard.
#[derive(Clone, Debug, Serialize)]
pub struct Trial {
    /// Runs of the sweep.
    pub sweep_runs: u64,
    /// Runs of the shard.
    pub runs: u64,
    /// Columns of the table.
    pub columns: Vec<String>,
    /// Files of rows.
    pub files: u64,
    /// Runs that were made.
    pub tried: u64,
    /// The number of failed ones among them.
    pub failed: u64,
    /// CPU time that each of them took (s).
    pub seconds_per_run: f64,
    /// Bytes that each of their rows takes in a file.
    pub bytes_per_row: f64,
}

impl Trial {
    /// Tries a shard of a sweep.
    ///
    /// # Errors
    /// [`SweepError::Model`] of the scene with the numbers of its files; [`SweepError::Interrupted`].
    pub fn new(sweep: &Sweep, shard: Shard, format: Format, interrupt: &AtomicBool) -> Result<Self, SweepError> {
        let range = shard.range(sweep.runs);
        let runs = range.end - range.start;
        let count = runs.min(MOST);
        let mut runner = Runner::new(sweep)?;
        // Other work on the machine takes wall-clock time, but no time of the thread.
        let (began, busy) = (Instant::now(), ThreadTime::now());
        let mut rows: Vec<Row> = Vec::new();
        for number in 0..count {
            if number > 0 && began.elapsed() > LONG_ENOUGH {
                break;
            }
            // Neighbours in a grid are alike: an odd multiple of the golden section visits all parts of it.
            let part = (number as f64 * 0.618_033_988_749_894_9).fract();
            let index = range.start + (part * runs as f64) as u64;
            match on_one_thread(|| runner.row(index.min(range.end - 1), interrupt)) {
                Some(row) => rows.push(row),
                None => return Err(SweepError::Interrupted { done: 0, runs }),
            }
        }
        let elapsed = busy.elapsed().as_secs_f64();
        let tried = rows.len() as u64;
        let columns = headings(sweep);
        // The bytes of a file without rows are no part of the rows.
        let bytes = |rows: &[Row]| format.size(&columns, rows) as f64;
        let bytes_per_row = match rows.len() {
            0 => 0.0,
            1 => bytes(&rows),
            count => (bytes(&rows) - bytes(&rows[..1])) / (count - 1) as f64,
        };
        Ok(Trial {
            sweep_runs: sweep.runs,
            runs,
            columns: columns.into_iter().map(|column| column.name).collect(),
            files: files(range, sweep.rows_per_file).count() as u64,
            tried,
            failed: rows.iter().filter(|row| row.failed).count() as u64,
            seconds_per_run: if tried == 0 { 0.0 } else { elapsed / tried as f64 },
            bytes_per_row,
        })
    }
}

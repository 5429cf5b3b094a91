//! Makes the runs of a sweep on all cores: threads take indices in their order, one writer puts rows on the disk.

use crate::simulation::parallel::threads::on_one_thread;
use crate::sweep::definition::Sweep;
use crate::sweep::error::SweepError;
use crate::sweep::folder::Folder;
use crate::sweep::one_run::Runner;
use crate::sweep::rows::{Cell, Row};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Rows are put on the disk that often.
const COMMIT: Duration = Duration::from_millis(500);

/// The approximate work that a thread takes at once.
const AT_ONCE: Duration = Duration::from_millis(5);

/// Most runs that a thread takes at once.
const MOST_AT_ONCE: u64 = 256;

/// How a sweep is worked on.
pub struct Work<'w> {
    /// Threads.
    pub jobs: usize,
    /// Set from outside to end it; runs that have begun are given up.
    pub interrupt: &'w AtomicBool,
    /// Receives the progress after each change.
    pub told: &'w mut dyn FnMut(&Done),
}

/// The progress.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Done {
    /// Runs of the sweep, or of its shard.
    pub runs: u64,
    /// Rows on the disk.
    pub done: u64,
    /// Runs that were made by this call.
    pub made: u64,
    /// The number of failed ones among them.
    pub failed: u64,
    /// The first of those: index and reason.
    pub first_failure: Option<(u64, String)>,
}

/// The indices that no thread has taken yet.
struct Queue(Mutex<std::vec::IntoIter<Range<u64>>>, Mutex<Range<u64>>);

impl Queue {
    /// The next indices, up to this number.
    fn take(&self, most: u64) -> Option<Range<u64>> {
        let mut current = self.1.lock().unwrap_or_else(PoisonError::into_inner);
        while current.is_empty() {
            *current = self.0.lock().unwrap_or_else(PoisonError::into_inner).next()?;
        }
        let end = (current.start + most).min(current.end);
        let taken = current.start..end;
        current.start = end;
        Some(taken)
    }
}

impl Work<'_> {
    /// Makes all runs that are missing in a folder.
    ///
    /// # Errors
    /// [`SweepError::Disk`] if rows cannot be written, [`SweepError::Interrupted`]; rows reported as done stay.
    pub fn finish(self, sweep: &Sweep, folder: &mut Folder) -> Result<Done, SweepError> {
        let mut done = Done { runs: folder.runs(), done: folder.done(), ..Done::default() };
        (self.told)(&done);
        let queue = Queue(Mutex::new(folder.pending().into_iter()), Mutex::new(0..0));
        // Ends all threads, on request or after rows could not be written.
        let stop = AtomicBool::new(false);
        let runners = (0..self.jobs.max(1)).map(|_| Runner::new(sweep)).collect::<Result<Vec<_>, _>>()?;
        let (sender, receiver) = sync_channel::<Vec<Row>>(4 * runners.len());
        let ended = std::thread::scope(|scope| {
            for runner in runners {
                let (sender, queue, stop) = (sender.clone(), &queue, &stop);
                scope.spawn(move || on_one_thread(|| make(runner, queue, stop, &sender)));
            }
            drop(sender);
            let mut written = || -> Result<(), SweepError> {
                let mut due = Instant::now() + COMMIT;
                loop {
                    if self.interrupt.load(Ordering::Relaxed) {
                        stop.store(true, Ordering::Relaxed);
                    }
                    let wait = due.saturating_duration_since(Instant::now()).min(COMMIT / 5);
                    let more = receiver.recv_timeout(wait);
                    let ended = more == Err(RecvTimeoutError::Disconnected);
                    for row in more.into_iter().flatten() {
                        done.count(&row);
                        folder.add(row)?;
                    }
                    if ended || Instant::now() >= due {
                        folder.commit()?;
                        done.done = folder.done();
                        (self.told)(&done);
                        due = Instant::now() + COMMIT;
                    }
                    if ended {
                        return Ok(());
                    }
                }
            };
            let written = written();
            stop.store(true, Ordering::Relaxed);
            // Threads that wait for room in the channel find that it has no receiver any more.
            drop(receiver);
            written
        });
        ended?;
        if done.done < done.runs {
            return Err(SweepError::Interrupted { done: done.done, runs: done.runs });
        }
        Ok(done)
    }
}

impl Done {
    fn count(&mut self, row: &Row) {
        self.made += 1;
        if row.failed {
            self.failed += 1;
            if self.first_failure.as_ref().is_none_or(|(first, _)| row.index < *first) {
                let status = row.cells.iter().position(|cell| *cell == Cell::Text("failed".to_string()));
                let reason = status.and_then(|status| row.cells.get(status + 1));
                let said = if let Some(Cell::Text(reason)) = reason { reason.clone() } else { String::new() };
                self.first_failure = Some((row.index, said));
            }
        }
    }
}

/// Makes runs until the queue is empty, or it shall stop.
fn make(mut runner: Runner, queue: &Queue, stop: &AtomicBool, sender: &SyncSender<Vec<Row>>) {
    let mut most = 1;
    while let Some(indices) = queue.take(most).filter(|_| !stop.load(Ordering::Relaxed)) {
        let began = Instant::now();
        let count = indices.end - indices.start;
        let rows: Vec<Row> = indices.map_while(|index| runner.row(index, stop)).collect();
        if sender.send(rows).is_err() {
            return;
        }
        let each = began.elapsed() / count as u32;
        most = (AT_ONCE.as_nanos() / each.as_nanos().max(1)).clamp(1, u128::from(MOST_AT_ONCE)) as u64;
    }
}

//! Independent work on several threads.

use std::cell::Cell;
use std::num::NonZero;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::available_parallelism;

/// Work that takes less than this (s) does not pay for threads, each of which takes some 50 µs to start and join.
const WORTH_THREADS: f64 = 1e-3;

/// How many there are; asking takes as long as a short run.
static PROCESSORS: OnceLock<usize> = OnceLock::new();

thread_local! {
    /// Whether this thread is one of many that are all busy.
    static ALONE: Cell<bool> = const { Cell::new(false) };
}

/// Does the work on this thread alone: runs in it start no threads, because there is one such piece of work for each processor. Results do not depend
/// on it.
pub fn on_one_thread<T>(work: impl FnOnce() -> T) -> T {
    let before = ALONE.replace(true);
    let done = work();
    ALONE.set(before);
    done
}

/// On how many threads islands are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Threads {
    /// As many as there are processors, where the work pays for them.
    WherePaid,
    /// This number, always.
    Exactly(usize),
}

impl Threads {
    pub(crate) fn at_most(self) -> usize {
        match self {
            Threads::WherePaid if ALONE.get() => 1,
            Threads::WherePaid => *PROCESSORS.get_or_init(|| available_parallelism().map_or(1, NonZero::get)),
            Threads::Exactly(count) => count,
        }
    }

    /// The number of threads for work that is expected to take this time (s) on one of them.
    pub(crate) fn for_work_of(self, seconds: f64) -> usize {
        if self == Threads::WherePaid && (seconds < WORTH_THREADS || ALONE.get()) { 1 } else { self.at_most() }
    }
}

/// Does the work on every item, on at most `threads` threads.
pub(crate) fn spread<T: Send>(items: &mut [T], threads: usize, work: impl Fn(&mut T) + Sync) {
    if threads.min(items.len()) < 2 {
        items.iter_mut().for_each(work);
        return;
    }
    let helpers = threads.min(items.len()) - 1;
    let queue = Mutex::new(items.iter_mut());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let drain = || {
        while let Some(item) = next() {
            work(item);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..helpers {
            scope.spawn(drain);
        }
        drain();
    });
}

//! CPU time of many short steps, measured once for all of them.
//!
//! ```text
//!     CPU time of the steps = CPU time of the thread · (wall time of the steps)/(wall time)        since the clock was started
//! ```
//!
//! CPU time needs a system call (some 0.3 µs), wall time does not. For that reason CPU time is read only at the start and at the end.

use cpu_time::ThreadTime;
use std::time::{Duration, Instant};

/// A clock that belongs to the thread that starts it.
pub(crate) struct Clock {
    processor: ThreadTime,
    wall: Instant,
}

impl Clock {
    /// Starts a clock on this thread.
    pub fn start() -> Self {
        Clock { processor: ThreadTime::now(), wall: Instant::now() }
    }

    /// CPU time (s) of work that took this wall time since the start. To be called on the thread that started the clock.
    pub fn share(&self, of: Duration) -> f64 {
        let share = of.as_secs_f64() / self.wall.elapsed().as_secs_f64().max(f64::MIN_POSITIVE);
        share.min(1.0) * self.processor.elapsed().as_secs_f64()
    }
}

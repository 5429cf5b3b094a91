//! CPU time of steps, where to ask for it is dearer than a step.
//!
//! ```text
//!     CPU time of the steps = CPU time of the thread · (wall time of the steps)/(wall time)        since the clock was started
//! ```
//!
//! The thread's own time is a call of the system (some 0.3 µs), the wall's is not: so the first is asked at the start and the end alone.

use cpu_time::ThreadTime;
use std::time::{Duration, Instant};

/// A clock of the thread that has started it.
pub(crate) struct Clock {
    processor: ThreadTime,
    wall: Instant,
}

impl Clock {
    /// Starts one.
    pub fn start() -> Self {
        Clock { processor: ThreadTime::now(), wall: Instant::now() }
    }

    /// CPU time (s) of what took so much time on the wall since the start, on the thread that has started it.
    pub fn share(&self, of: Duration) -> f64 {
        let share = of.as_secs_f64() / self.wall.elapsed().as_secs_f64().max(f64::MIN_POSITIVE);
        share.min(1.0) * self.processor.elapsed().as_secs_f64()
    }
}

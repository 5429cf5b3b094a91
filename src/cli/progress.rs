//! The progress bar on a terminal: a note during trial runs; then simulated time, speed against real time, time left.

use catena::simulation::{Observer, ObserverError, Sample};
use indicatif::{ProgressBar, ProgressStyle};
use std::time::{Duration, Instant};

/// Pauses between two looks of the bar; terminals show no more.
const INTERVAL: Duration = Duration::from_millis(100);

/// Moves a bar on standard error along with the run.
pub struct Progress {
    bar: ProgressBar,
    duration: f64,
    started: Instant,
    drawn: Instant,
}

impl Progress {
    /// A bar for a run of this many simulated seconds.
    pub fn new(duration: f64) -> Self {
        // In thousandths of the whole, because the bar counts in integers.
        let bar = ProgressBar::new(1000);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {msg}, {eta} left") {
            bar.set_style(style);
        }
        let now = Instant::now();
        Progress { bar, duration, started: now, drawn: now }
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Says on standard error that trial runs are being made, for as long as it lives.
pub struct PilotsShown(ProgressBar);

impl PilotsShown {
    /// With the time they have taken.
    pub fn new() -> Self {
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} trial runs for the accuracy, {elapsed}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(INTERVAL);
        PilotsShown(bar)
    }
}

impl Drop for PilotsShown {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

impl Observer for Progress {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        if self.drawn.elapsed() >= INTERVAL {
            self.drawn = Instant::now();
            let speed = sample.time / self.started.elapsed().as_secs_f64();
            self.bar.set_position((1000.0 * sample.time / self.duration) as u64);
            self.bar.set_message(format!("{:.2} of {} s, {speed:.1} × real time", sample.time, self.duration));
        }
        Ok(())
    }
}

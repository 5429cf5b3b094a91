//! The progress bar on a terminal: simulated time, accuracy so far, speed against real time, time left.

use catena::mechanism::ground::words::rounded;
use catena::mechanism::motion::integrator::MethodDescription;
use catena::simulation::{AccuracySoFar, Observer, ObserverError, Sample};
use indicatif::{ProgressBar, ProgressStyle};
use std::time::{Duration, Instant};

/// Pauses between two looks of the bar; terminals show no more.
const INTERVAL: Duration = Duration::from_millis(100);

/// Moves a bar on standard error along with the run. Copies move the same bar.
#[derive(Clone)]
pub struct Progress {
    bar: ProgressBar,
    duration: f64,
    started: Option<Instant>,
    drawn: Instant,
    accuracy: Option<AccuracySoFar>,
}

impl Progress {
    /// A bar for a run of this many simulated seconds.
    pub fn new(duration: f64) -> Self {
        // In thousandths of the whole, because the bar counts in integers.
        let bar = ProgressBar::new(1000);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {msg}, {eta} left") {
            bar.set_style(style);
        }
        Progress { bar, duration, started: None, drawn: Instant::now(), accuracy: None }
    }

    /// A copy as runs take it.
    pub fn boxed(&self) -> Box<dyn Observer> {
        Box::new(self.clone())
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// A bar on standard error that counts pictures.
pub struct Pictures {
    bar: ProgressBar,
}

impl Pictures {
    /// A bar of nothing yet; `hidden` shows none.
    pub fn new(hidden: bool) -> Self {
        let bar = if hidden { ProgressBar::hidden() } else { ProgressBar::new(0) };
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos} of {len} pictures, {eta} left") {
            bar.set_style(style);
        }
        Pictures { bar }
    }

    /// So many pictures of all are drawn.
    pub fn show(&self, drawn: usize, all: usize) {
        self.bar.set_length(all as u64);
        self.bar.set_position(drawn as u64);
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Observer for Progress {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let started = *self.started.get_or_insert_with(Instant::now);
        if self.drawn.elapsed() >= INTERVAL {
            self.drawn = Instant::now();
            let speed = sample.time / started.elapsed().as_secs_f64();
            self.bar.set_position((1000.0 * sample.time / self.duration) as u64);
            let accuracy = self.accuracy.as_ref().map_or_else(String::new, said);
            self.bar
                .set_message(format!("{:.2} of {} s{accuracy}, {speed:.1} × real time", sample.time, self.duration));
        }
        Ok(())
    }

    fn accuracy(&mut self, so_far: &AccuracySoFar) {
        self.accuracy = Some(*so_far);
    }

    fn skips_contacts(&self) -> bool {
        true
    }

    fn begin_again(&mut self, _: &MethodDescription) -> Result<(), ObserverError> {
        self.accuracy = None;
        Ok(())
    }
}

/// The accuracy so far in a few words.
fn said(so_far: &AccuracySoFar) -> String {
    if so_far.holds() {
        format!(", estimated error {:.0e} m", so_far.estimate)
    } else {
        format!(", accurate to {:e} m until t = {} s", so_far.wanted, rounded(so_far.holds_until))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_says_the_error_so_far_and_once_that_is_too_large_until_when_it_was_not() {
        let held = AccuracySoFar { time: 3.9, wanted: 1e-6, estimate: 2.4e-8, holds_until: 3.9 };
        assert_eq!(said(&held), ", estimated error 2e-8 m");
        let lost = AccuracySoFar { estimate: f64::INFINITY, holds_until: 3.87, ..held };
        assert_eq!(said(&lost), ", accurate to 1e-6 m until t = 3.87 s");
    }
}

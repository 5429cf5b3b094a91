//! Forecasts the error at the end of a run from its growth so far, and how much finer the steps must be to meet the tolerance.
//!
//! A run iterates its steps until increments are below a stop `ε`, and estimates its largest error so far, `e(t)`, during the run. Errors are
//! proportional to the stop, and grow by a factor per step that is characteristic of the motion. There are `n` steps until `t` and `N = n T/t` until
//! the end:
//!
//! ```text
//!     g = (log₁₀(e/ε) + M g₀) / (n + M)        growth a step, drawn to what is usual, g₀ = 0.04, as if M = 15 steps had been seen before
//!     ê = e max(10^{g (N − n)}, T/t)           the error at the end                                                    (m)
//!     ε ← min(ε/10, ε E/(300 ê))               where e > E/2, or where ê > 3 E at T/16, T/8, T/4, 3T/8, T/2 or 5T/8
//! ```
//!
//! `E` is the wanted accuracy. The constants are a compromise for 700 random motions: the least total time, and the fewest motions that took several
//! times as long as their accepted run (`doc/decisions/006-cost-of-a-tolerance.md`). Below a stop of 1e-13 there are only rounding errors; so the
//! second restart uses the finest stop. So does the first one of a run with events, because there impacts amplify errors, and a run that is finer by
//! ten thousand keeps its accuracy hardly longer.

/// The finest stop, at rounding.
pub(crate) const FINEST: f64 = 1e-16;
/// Below this stop errors are rounding errors.
pub(crate) const ROUNDED: f64 = 1e-13;
/// The prior: a growth of errors per step in powers of ten,
const USUAL: f64 = 0.04;
/// with the weight of this many observed steps.
const SEEN: f64 = 15.0;
/// A restart of a run with events whose stop would be below this has the finest stop.
const FINEST_WITH_EVENTS: f64 = 3e-13;
/// A run is too coarse if its forecast error exceeds the tolerance by this factor.
const TOO_COARSE: f64 = 3.0;
/// A restarted run aims at the wanted accuracy over this.
const AIM: f64 = 300.0;
/// A run that has parted from its companion restarts with a stop smaller by this factor.
const PARTED: f64 = 1e-4;
/// Runs of fewer steps are not forecast, because restarting them would save little.
const FEWEST: f64 = 30.0;
/// Times of the forecasts, over the duration.
const INSTANTS: [f64; 6] = [1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 3.0 / 8.0, 1.0 / 2.0, 5.0 / 8.0];

/// The data and the target of a forecast.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// The wanted accuracy (m).
    pub accuracy: f64,
    /// The iteration stop.
    pub stop: f64,
    /// When the run begins and ends (s).
    pub start: f64,
    pub end: f64,
    /// Whether its errors may grow exponentially. Motions with one degree of freedom are not chaotic.
    pub grows: bool,
    /// Whether it has events.
    pub events: bool,
}

/// Forecasts of a run at a few instants.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forecast {
    wanted: Wanted,
    /// Number of instants that have passed.
    looked: usize,
}

impl Forecast {
    /// A forecast before the first step.
    pub fn new(wanted: Wanted) -> Self {
        Forecast { wanted, looked: 0 }
    }

    /// The forecasts before a time (s) were made by others.
    pub fn go_on_from(&mut self, time: f64) {
        self.looked = self.due(time);
    }

    /// The number of instants up to a time (s).
    fn due(&self, time: f64) -> usize {
        let Wanted { start, end, .. } = self.wanted;
        INSTANTS.iter().filter(|&&share| time - start >= share * (end - start)).count()
    }

    /// The forecast error at the end (m) if the run must restart, from its error at a time (s) after this many steps, and from an error that does not
    /// grow (m).
    pub fn too_coarse(&mut self, time: f64, steps: usize, error: f64, constant: f64) -> Option<f64> {
        let Wanted { accuracy, stop, start, end, grows, .. } = self.wanted;
        let (passed, whole, steps) = (time - start, end - start, steps as f64);
        let all = steps * whole / passed;
        let growth = ((error / stop).log10().max(0.0) + SEEN * USUAL) / (steps + SEEN);
        let by_steps = if grows { 10_f64.powf(growth * (all - steps)) } else { 1.0 };
        let predicted = error * by_steps.max(whole / passed);
        let due = self.due(time);
        let is_due = due > std::mem::replace(&mut self.looked, due);
        let is_over = error.is_nan() || error > 0.5 * accuracy;
        let will_be = is_due && grows && all >= FEWEST && predicted > TOO_COARSE * accuracy;
        if is_over || will_be {
            return Some(predicted);
        }
        (constant > 0.5 * accuracy).then_some(constant)
    }

    /// The stop of the restarted run, from the forecast error at the end (m); `again` for a second restart.
    pub fn finer(&self, predicted: f64, again: bool) -> f64 {
        let Wanted { accuracy, stop, events, .. } = self.wanted;
        // A run that has parted only shows that it was much too coarse.
        let wanted = if predicted.is_finite() { stop * accuracy / (AIM * predicted) } else { PARTED * stop };
        let stop = wanted.min(0.1 * stop).max(FINEST);
        if again && stop < ROUNDED || events && stop < FINEST_WITH_EVENTS { FINEST } else { stop }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: Wanted = Wanted { accuracy: 1e-6, stop: 1e-8, start: 2.0, end: 12.0, grows: true, events: false };

    #[test]
    fn an_error_above_half_of_what_is_wanted_begins_the_run_again_and_a_smaller_one_does_not() {
        let look = |error| Forecast::new(WANTED).too_coarse(2.1, 5, error, 0.0).is_some();
        assert!([4.9e-7, 5.1e-7, f64::INFINITY, f64::NAN].map(look) == [false, true, true, true]);
    }

    #[test]
    fn errors_that_grow_by_a_tenth_each_step_are_forecast_at_a_sixteenth_of_the_run() {
        // 50 steps of 400, with an error of 10^0.1 a step: at 1/16 it is 1e-8 · 10^2.5, at the end it would be 1e-8 · 10^40.
        let mut forecast = Forecast::new(WANTED);
        assert_eq!(forecast.too_coarse(2.6, 24, 1e-8, 0.0), None, "before the first instant");
        let predicted = forecast.too_coarse(2.0 + 10.0 / 16.0, 25, 3.2e-8, 0.0).expect("too coarse");
        // g = (0.5 + 0.6)/40, 375 steps left.
        let expected = 3.2e-8 * 10_f64.powf(375.0 * (3.2_f64.log10() + 0.6) / 40.0);
        assert!((predicted / expected - 1.0).abs() < 1e-9, "{predicted:e}, not {expected:e}");
        assert_eq!(forecast.too_coarse(2.7, 28, 3.2e-8, 0.0), None, "once at each instant");
        assert_eq!(forecast.finer(predicted, false), FINEST, "of {predicted:e} m");
        let finer = forecast.finer(1e-3, false);
        assert!((finer / (1e-8 * 1e-6 / (300.0 * 1e-3)) - 1.0).abs() < 1e-12, "{finer:e}");
    }

    #[test]
    fn an_error_that_does_not_grow_begins_the_run_again_with_a_stop_for_itself() {
        let mut forecast = Forecast::new(WANTED);
        assert_eq!(forecast.too_coarse(2.1, 5, 1e-9, 4.9e-7), None);
        assert_eq!(forecast.too_coarse(2.2, 10, 1e-9, 8e-6), Some(8e-6));
    }

    #[test]
    fn a_run_of_few_steps_or_of_one_freedom_is_not_forecast() {
        let at = 2.0 + 10.0 / 16.0;
        assert_eq!(Forecast::new(WANTED).too_coarse(at, 1, 3e-7, 0.0), None, "16 steps in all");
        let calm = Wanted { grows: false, ..WANTED };
        assert_eq!(Forecast::new(calm).too_coarse(at, 25, 3e-7, 0.0), None, "one freedom");
    }

    #[test]
    fn a_run_with_events_restarts_once_if_it_would_need_nearly_the_finest_stop() {
        let forecast = Forecast::new(Wanted { stop: 1e-9, events: true, ..WANTED });
        // 1e-9 · 1e-6 / (300 · 1e-3) is 3e-15, and with 1e-6 it is 3e-12.
        assert_eq!(forecast.finer(1e-3, false), FINEST);
        let finer = forecast.finer(1e-6, false);
        assert!((finer / (1e-9 / 300.0) - 1.0).abs() < 1e-12, "{finer:e}");
        // One that has parted from its companion.
        assert_eq!(forecast.finer(f64::INFINITY, false), FINEST);
    }

    #[test]
    fn stops_among_roundings_are_the_finest_from_the_second_time_on() {
        let forecast = Forecast::new(Wanted { stop: 1e-11, ..WANTED });
        assert_eq!(forecast.finer(1e-4, true), FINEST);
        let once = forecast.finer(1e-4, false);
        assert!((once / (1e-13 / 300.0) - 1.0).abs() < 1e-12, "{once:e}");
        assert_eq!(forecast.finer(f64::INFINITY, false), 1e-4 * 1e-11);
        // A restarted run is always finer, however small the error.
        assert!((forecast.finer(1e-12, false) / 1e-12 - 1.0).abs() < 1e-12);
    }
}

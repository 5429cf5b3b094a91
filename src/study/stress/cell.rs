//! One cell of a map: one run and its result.
//!
//! `e` is the error of the watched bodies at the end, and `L` the size of the mechanism (m). The energy error `ε` is the change of all energy, less
//! the work put in, plus the energy dissipated. It is relative to the largest kinetic energy of the right motion, or of the end if that motion is not
//! known:
//!
//! ```text
//!     accurate    e ≤ max(10⁻⁶ L, 3 × the doubt of the answer)
//!     usable      e ≤ 10⁻² L, or the tolerance that was asked for
//!     warned      more, but the run says that it was beyond its limit of stability, that its energy does not balance, or until when it
//!                 is accurate
//!     wrong       more, without a word, or an end where there is none
//! ```
//!
//! If motions that start together part, no two runs agree, and there is no answer. Then the energy alone decides: accurate at `ε ≤ 10⁻⁶`, usable at
//! `ε ≤ 10⁻²`, wrong beyond.

use crate::chart::Setting;
use crate::mechanism::motion::distance::distance;
use crate::stress::method::Method;
use crate::stress::problem::Case;
use crate::stress::runner::{Failure, Refused, Runner};
use crate::stress::truth::{Answer, watched_probes};
use cpu_time::ThreadTime;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

/// Largest error of an accurate end, as a part of the size or of the energy.
pub const ACCURATE: f64 = 1e-6;
/// Largest error of a usable end.
pub const USABLE: f64 = 1e-2;
/// An energy error beyond this is garbage, not coarseness.
pub const GARBAGE: f64 = 0.5;

/// CPU time after which a run is too slow whatever it has done, as a multiple of its budget of rough work.
const PATIENCE: f64 = 15.0;
/// Part of the budget after which it shows whether a run will keep to it.
const FORESIGHT: f64 = 0.05;
/// A run is given up then if it would exceed its budget by this factor at its pace so far. The factor is larger for chosen steps, which are short
/// where the motion begins.
const HOPELESS: [f64; 2] = [2.0, 20.0];

/// The verdict about a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// It came to the right end.
    Accurate,
    /// It came near the right end.
    Usable,
    /// It came to a wrong end with a warning.
    Warned,
    /// It came to a wrong end without a warning.
    Wrong,
    /// It ended with an error.
    Failed,
    /// It cost too much.
    TooSlow,
    /// The method does not know such a mechanism.
    NotApplicable,
}

impl Verdict {
    /// All of them, best first, in the order of the legend.
    pub const ALL: [Verdict; 7] = [
        Verdict::Accurate,
        Verdict::Usable,
        Verdict::Warned,
        Verdict::Wrong,
        Verdict::Failed,
        Verdict::TooSlow,
        Verdict::NotApplicable,
    ];

    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Accurate => "accurate",
            Verdict::Usable => "usable",
            Verdict::Warned => "warned",
            Verdict::Wrong => "wrong",
            Verdict::Failed => "failed",
            Verdict::TooSlow => "too slow",
            Verdict::NotApplicable => "not applicable",
        }
    }

    /// The words for it in the legend.
    pub fn legend(self) -> &'static str {
        match self {
            Verdict::Accurate => "accurate: 10⁻⁶ of the size",
            Verdict::Usable => "usable: 10⁻²",
            Verdict::Warned => "wrong, with a warning",
            Verdict::Wrong => "wrong, silently",
            Verdict::Failed => "stopped with an error",
            Verdict::TooSlow => "too slow",
            Verdict::NotApplicable => "not applicable",
        }
    }

    /// Whether the run came to an end that is of use.
    pub fn survived(self) -> bool {
        matches!(self, Verdict::Accurate | Verdict::Usable)
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ended {
    /// At the end.
    Survived,
    /// It ended with an error.
    Failed(Failure),
    /// It was cut at this time (s).
    TimedOut {
        /// Simulated time reached (s).
        time: f64,
    },
    /// It did not begin.
    NotApplicable(&'static str),
}

/// One run of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The method.
    pub method: Method,
    /// Its setting.
    pub setting: Setting,
    /// Place of the difficulty in the problem.
    pub place: usize,
    /// How it ended.
    pub ended: Ended,
    /// The verdict about that end.
    pub verdict: Verdict,
    /// Error of the end (m); NaN if it is not known.
    pub end_error: f64,
    /// Energy error, relative to the largest kinetic energy; NaN if the run did not come to its end.
    pub energy_error: f64,
    /// CPU time (s).
    pub cpu_seconds: f64,
    /// The warning of the run.
    pub warning: Option<String>,
}

impl Cell {
    /// Whether the run ended with meaningless numbers, and with neither an error nor a warning: a defect. An inaccurate motion that has its energy is
    /// no such defect.
    pub fn is_silent_garbage(&self) -> bool {
        let meaningless = !self.energy_error.is_finite() || self.energy_error > GARBAGE;
        self.ended == Ended::Survived && self.verdict == Verdict::Wrong && meaningless
    }

    /// Makes the run; `None` if interrupted.
    pub fn run(
        case: &Case,
        answer: &Answer,
        method: Method,
        setting: Setting,
        place: usize,
        interrupt: &AtomicBool,
    ) -> Option<Self> {
        let mut cell = Cell {
            method,
            setting,
            place,
            ended: Ended::Survived,
            verdict: Verdict::Failed,
            end_error: f64::NAN,
            energy_error: f64::NAN,
            cpu_seconds: 0.0,
            warning: None,
        };
        let clock = ThreadTime::now();
        // A panic in one cell is a finding, and must not take the map with it.
        let run = catch_unwind(AssertUnwindSafe(|| cell.go(case, answer, &clock, interrupt)));
        let completed = run.unwrap_or_else(|_| {
            let message = "the method panicked".to_string();
            cell.ended = Ended::Failed(Failure { name: "Panic", time: case.start.time, message });
            Some(())
        });
        cell.cpu_seconds = clock.elapsed().as_secs_f64();
        cell.verdict = cell.judge(answer);
        completed.map(|()| cell)
    }

    fn go(&mut self, case: &Case, answer: &Answer, clock: &ThreadTime, interrupt: &AtomicBool) -> Option<()> {
        let mut runner = match Runner::new(case, self.method, self.setting, interrupt) {
            Ok(runner) => runner,
            Err(Refused::NotApplicable(reason)) => {
                self.ended = Ended::NotApplicable(reason);
                return Some(());
            }
            Err(Refused::Failed(failure)) => {
                self.ended = Ended::Failed(failure);
                return Some(());
            }
            Err(Refused::TooSlow) => {
                self.ended = Ended::TimedOut { time: case.start.time };
                return Some(());
            }
            Err(Refused::Interrupted) => return None,
        };
        let (first, end) = (runner.energy(), case.start.time + case.duration);
        let (mut spent, mut steps) = (0.0, 0_usize);
        let hopeless = HOPELESS[usize::from(self.method.is_adaptive())] * case.budget / case.duration;
        while runner.time() < end {
            match runner.advance(end) {
                Ok(work) => spent += work,
                Err(failure) => {
                    self.ended = Ended::Failed(failure);
                    break;
                }
            }
            steps += 1;
            if interrupt.load(Ordering::Relaxed) {
                return None;
            }
            // Looking at the clock costs as much as a small step.
            let impatient = steps.is_multiple_of(16) && clock.elapsed().as_secs_f64() > PATIENCE * case.budget;
            let behind = runner.time() - case.start.time;
            if spent > case.budget || impatient || (spent > FORESIGHT * case.budget && spent > hopeless * behind) {
                if runner.time() < end {
                    self.ended = Ended::TimedOut { time: runner.time() };
                }
                break;
            }
        }
        self.warning = runner.warning();
        if self.ended == Ended::Survived {
            let last = runner.energy();
            let moving = if answer.kinetic > 0.0 { answer.kinetic } else { last.0 };
            let scale = moving.max(first.0).max(f64::MIN_POSITIVE);
            self.energy_error = (last.1 - first.1).abs() / scale;
            let found = watched_probes(&case.mechanism, &runner, case.watched);
            if self.warning.is_none() {
                self.warning = runner.energy_warning(self.energy_error);
            }
            self.end_error = answer.probes.as_ref().map_or(f64::NAN, |probes| distance(probes, &found));
        }
        Some(())
    }

    fn judge(&self, answer: &Answer) -> Verdict {
        match &self.ended {
            Ended::Failed(_) => return Verdict::Failed,
            Ended::TimedOut { .. } => return Verdict::TooSlow,
            Ended::NotApplicable(_) => return Verdict::NotApplicable,
            Ended::Survived => {}
        }
        let (error, accurate) = match (&answer.probes, answer.refusal) {
            (_, Some(_)) => return Verdict::Wrong,
            (Some(_), None) => (self.end_error / answer.size, ACCURATE.max(3.0 * answer.doubt)),
            (None, None) => (self.energy_error, ACCURATE),
        };
        let usable = match self.setting {
            Setting::Tolerance(tolerance) if answer.probes.is_some() => USABLE.max(tolerance / answer.size),
            _ => USABLE,
        };
        // NaN is wrong.
        if error <= accurate {
            Verdict::Accurate
        } else if error <= usable {
            Verdict::Usable
        } else if self.warning.is_some() {
            Verdict::Warned
        } else {
            Verdict::Wrong
        }
    }
}

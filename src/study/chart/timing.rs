//! The cost of a run: CPU time of the thread in the integration loop only.
//!
//! Building the integrator, kinematics, energy and samples are outside the clock, and what the clock takes for being read
//! is taken off. A run is repeated until the clock has seen [`Effort::total`] seconds and [`Effort::repeats`] runs, and
//! the fastest counts: whatever else the machine does only ever makes a run slower.

use crate::chart::method::{Method, Setting};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::integrator::Integrator;
use crate::mechanism::motion::state::State;
use cpu_time::ThreadTime;
use std::fmt;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ended {
    /// It reached the end.
    Done,
    /// It failed; the words say how.
    Failed(String),
    /// It cost more than the cap and was cut at this time (s).
    Cut {
        /// Simulated time reached (s).
        time: f64,
    },
    /// The user asked to stop.
    Interrupted,
}

impl fmt::Display for Ended {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Ended::Done => write!(out, "done"),
            Ended::Failed(reason) => write!(out, "failed: {reason}"),
            Ended::Cut { time } => write!(out, "cut at t = {time} s: too slow"),
            Ended::Interrupted => write!(out, "interrupted"),
        }
    }
}

/// How much work to put into a timing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// A single run is cut when it has used this much CPU time (s).
    pub cap: f64,
    /// Runs are repeated until they have used this much CPU time together (s).
    pub total: f64,
    /// Least number of repetitions, unless runs are long.
    pub repeats: usize,
    /// No repetition once the runs have used this much together (s).
    pub enough: f64,
}

/// One run and its cost.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedRun {
    /// The state at the end.
    pub end: State,
    /// CPU time of the fastest repetition (s).
    pub cpu_seconds: f64,
    /// Accepted steps.
    pub steps: usize,
    /// Iterations, or evaluations of the right-hand side.
    pub iterations: usize,
    /// Attempts thrown away.
    pub rejected: usize,
    /// Mean length of the steps (s).
    pub mean_step: f64,
    /// Energy dissipated, and work put in (J).
    pub exchange: Exchange,
    /// How it ended.
    pub ended: Ended,
}

impl TimedRun {
    /// A run without steps so far.
    fn empty(start: &State) -> Self {
        TimedRun {
            end: start.clone(),
            cpu_seconds: 0.0,
            steps: 0,
            iterations: 0,
            rejected: 0,
            mean_step: 0.0,
            exchange: Exchange::default(),
            ended: Ended::Done,
        }
    }
}

/// Runs a method from `start` for `duration` seconds, as often as `effort` asks.
pub fn timed_run(
    mechanism: &Mechanism,
    start: &State,
    duration: f64,
    method: Method,
    setting: Setting,
    effort: &Effort,
    interrupt: &AtomicBool,
) -> TimedRun {
    let once = || single_run(mechanism, start, duration, method, setting, effort.cap, interrupt);
    let mut best = once();
    let (mut total, mut runs) = (best.cpu_seconds, 1);
    while best.ended == Ended::Done && total < effort.enough && (total < effort.total || runs < effort.repeats) {
        let again = once();
        if again.ended != Ended::Done {
            // The cause is an interruption or a very unlucky cap: the measurements so far are kept.
            break;
        }
        total += again.cpu_seconds;
        runs += 1;
        best.cpu_seconds = best.cpu_seconds.min(again.cpu_seconds);
    }
    best
}

fn single_run(
    mechanism: &Mechanism,
    start: &State,
    duration: f64,
    method: Method,
    setting: Setting,
    cap: f64,
    interrupt: &AtomicBool,
) -> TimedRun {
    let mut state = start.clone();
    let end = start.time + duration;
    let mut run = TimedRun::empty(start);
    let mut telling = method.telling(mechanism, start, duration, setting);
    let mut plain = if telling.is_none() { method.integrator(mechanism, start, setting) } else { None };
    let reading = seconds_a_reading();
    let clock = ThreadTime::now();
    let mut readings = 1.0;
    while state.time < end {
        let advanced = match (&mut telling, &mut plain) {
            (Some(telling), _) => telling.advance(mechanism, &mut state, end),
            (None, Some(plain)) => plain.advance(mechanism, &mut state, end),
            (None, None) => {
                run.ended = Ended::Failed(format!("{} does not know {setting}", method.id()));
                break;
            }
        };
        // All of the time counts, and the steps of the run that there is in the end.
        if let Some(telling) = telling.as_mut().filter(|telling| telling.begins_again()) {
            if let Err(error) = telling.begin_again(mechanism) {
                run.ended = Ended::Failed(error.to_string());
                break;
            }
            state.copy_from(start);
            run = TimedRun::empty(start);
            continue;
        }
        match advanced {
            Ok(outcome) => {
                run.steps += 1;
                run.iterations += outcome.cost.iterations;
                run.rejected += outcome.cost.rejected.total();
                run.exchange += outcome.exchange;
            }
            Err(error) => {
                run.ended = Ended::Failed(error.to_string());
                break;
            }
        }
        // Looking at the clock costs as much as a small step.
        if run.steps.is_multiple_of(32) {
            if interrupt.load(Ordering::Relaxed) {
                run.ended = Ended::Interrupted;
                break;
            }
            readings += 1.0;
            if clock.elapsed().as_secs_f64() > cap {
                run.ended = Ended::Cut { time: state.time };
                break;
            }
        }
    }
    run.cpu_seconds = (clock.elapsed().as_secs_f64() - readings * reading).max(SHORTEST);
    run.mean_step = (state.time - start.time) / run.steps.max(1) as f64;
    let is_finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    if run.ended == Ended::Done && !(is_finite(&state.position) && is_finite(&state.velocity)) {
        run.ended = Ended::Failed("the end state is not finite".to_string());
    }
    run.end = state;
    run
}

/// No run counts as shorter (s): the axis of the picture is logarithmic, and runs are repeated until they add up to something.
const SHORTEST: f64 = 1e-9;

/// The least cost of a reading of the clock (s): 0.4 µs, a twentieth of a short run of two bodies.
fn seconds_a_reading() -> f64 {
    static SECONDS: OnceLock<f64> = OnceLock::new();
    let apart = |_| ThreadTime::now().elapsed().as_secs_f64();
    *SECONDS.get_or_init(|| (0..1000).map(apart).fold(f64::INFINITY, f64::min))
}

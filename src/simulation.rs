//! The loop: step, sample, observe, until the end of the run.
//!
//! An [`Integrator`] advances the state and can be asked for any instant of its last step; [`Observer`]s see samples at
//! a fixed rate (the log) and the end of every step (energy, constraint and solver figures). The loop is the same for
//! the Lobatto scheme and for the reduced-coordinate comparators, so that charts compare like with like.

use crate::forces::total::Exchange;
use crate::invariants::{Energy, Violation, energy_with_forces, violation};
use crate::kinematics::{WORLD, body_states, forward_kinematics};
use crate::model::Mechanism;
use crate::state::{BodyState, State};
use cpu_time::ThreadTime;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What an integrator is and how it has stepped so far; goes into reports and logs.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodDescription {
    /// Short name: `lobatto`, `dop853`, `rk4`, `euler`.
    pub name: String,
    /// Number of stages of the scheme.
    pub stages: usize,
    /// Order of convergence.
    pub order: usize,
    /// The fixed step, or the mean accepted step of an adaptive run (s).
    pub step: f64,
    /// Whether the step is chosen from a tolerance.
    pub adaptive: bool,
    /// The tolerance the step is chosen from.
    pub tolerance: Option<f64>,
    /// The nearest that any step came to the limit of linear stability, as far as it was looked at.
    pub frequency_step: Option<FrequencyStep>,
    /// Where the closures were nearest to saying less than elsewhere, as far as ends of steps show it.
    pub singular: Option<SingularPosition>,
    /// How often the symmetry of reversible steps was broken; `None` for steps that are not.
    pub reversible_resets: Option<usize>,
}

/// An end of a step within about a milliradian of a singular position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingularPosition {
    /// When (s).
    pub time: f64,
    /// How many more equations are redundant there than elsewhere in the run.
    pub extra: usize,
}

/// The nearest that a run has come to the limit of stability, or the first step beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyStep {
    /// `h ω`: step times frequency of the fastest mode.
    pub product: f64,
    /// Where the scheme becomes unstable.
    pub limit: f64,
    /// The step (s).
    pub step: f64,
    /// When (s).
    pub time: f64,
}

impl FrequencyStep {
    /// Whether a step was beyond the limit.
    pub fn is_unstable(&self) -> bool {
        self.product > self.limit
    }

    /// The longest stable step where this one was made (s); infinite where nothing is stiff.
    pub fn longest(&self) -> f64 {
        self.step * self.limit / self.product
    }
}

/// What one accepted step cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepOutcome {
    /// Length of the step (s).
    pub step: f64,
    /// Iterations of the nonlinear solve, or evaluations of the right-hand side.
    pub iterations: usize,
    /// Attempts that were thrown away before this step was accepted.
    pub rejected: usize,
    /// Energy dissipated in the step, and work put into the mechanism (J).
    pub exchange: Exchange,
}

/// Why a step could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    /// The stage equations could not be solved, even after the step was shortened again and again.
    #[error(
        "at t = {time} s the step from joint {joint:?} did not converge (last increment {increment:.1e}), not even with \
         a step of {step:.1e} s; choose a smaller --step, more --stages or a smaller --tolerance"
    )]
    NotConverged { time: f64, step: f64, joint: String, increment: f64 },
    /// The stage equations could not be solved, and the step was beyond what the scheme is stable for.
    #[error(
        "at t = {time} s a step of {step:.1e} s is beyond the stability limit of {stages} stages and does not converge; use \
         --step below {longest:.1e} s, more --stages, or --tolerance"
    )]
    Unstable { time: f64, step: f64, stages: usize, longest: f64 },
    /// A joint turns by more than half a revolution within the shortest step.
    #[error(
        "at t = {time} s joint {joint:?} turns by more than half a revolution within a step of {step:.1e} s; choose a smaller --step"
    )]
    TurnedTooFar { time: f64, step: f64, joint: String },
    /// Every step changes the energy by more than the tolerance allows, however short.
    #[error("at t = {time} s no step is accurate enough, not even {step:.1e} s; choose a larger --tolerance")]
    NotAccurate { time: f64, step: f64 },
    /// The state is not finite any more.
    #[error(
        "at t = {time} s the velocity of joint {joint:?} is not finite; the motion is too violent for the step {step:.1e} s"
    )]
    NotFinite { time: f64, step: f64, joint: String },
}

/// A way of advancing the state of a mechanism.
pub trait Integrator {
    /// Makes one step that ends at or before `until`, and exactly at `until` if the step reaches it.
    ///
    /// # Errors
    /// [`StepError`] when no step could be made; the state is then that of the last accepted step.
    fn advance(&mut self, mechanism: &Mechanism, state: &mut State, until: f64) -> Result<StepOutcome, StepError>;

    /// Positions and velocities at a `time` inside the last step, from its dense output.
    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]);

    /// What this integrator is.
    fn description(&self) -> MethodDescription;
}

/// The mechanism at one sampled instant.
pub struct Sample<'s> {
    /// The sampled time (s).
    pub time: f64,
    /// Joint positions and velocities from dense output.
    pub position: &'s [f64],
    /// Joint velocities from dense output.
    pub velocity: &'s [f64],
    /// The end of the step in which the sample lies (or the start of the run).
    pub step: &'s StepEnd,
}

/// The figures at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepEnd {
    /// Time at the end of the step (s).
    pub time: f64,
    /// Energy there.
    pub energy: Energy,
    /// Energy dissipated since the start of the run, and work put in (J).
    pub exchange: Exchange,
    /// Constraint violation there.
    pub violation: Violation,
    /// What the step cost.
    pub outcome: StepOutcome,
    /// Accepted steps, their iterations and attempts thrown away, from the start of the run to here.
    pub so_far: Counts,
}

/// What a run, or a part of it, has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Accepted steps.
    pub steps: usize,
    /// Iterations of all steps.
    pub iterations: usize,
    /// Attempts thrown away.
    pub rejected: usize,
}

/// Anything an observer may fail with (a full disk, a closed pipe).
pub type ObserverError = Box<dyn std::error::Error + Send + Sync>;

/// Sees a run as it goes along.
pub trait Observer {
    /// A sample of the motion, in order of time, the first at the start and the last at the end of the run.
    ///
    /// # Errors
    /// Whatever stops the run, for instance a disk that is full.
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError>;

    /// The end of a step, before the samples inside it.
    fn step(&mut self, _end: &StepEnd) {}
}

/// What to run and how to watch it.
pub struct RunOptions<'o> {
    /// Simulated time to run (s).
    pub duration: f64,
    /// Samples per simulated second, `None` for the first and the last instant only.
    pub rate: Option<f64>,
    /// Set from outside to end the run after the current step.
    pub interrupt: Option<&'o AtomicBool>,
}

/// The figures of a whole run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Accepted steps.
    pub steps: usize,
    /// Iterations of all steps.
    pub iterations: usize,
    /// Attempts thrown away.
    pub rejected_steps: usize,
    /// CPU time in the integrator alone (s): that of the thread, divided as the clock on the wall divides it. To ask for the
    /// thread's own time is a call of the system, which would take as long as a small step.
    pub solve_cpu_seconds: f64,
    /// Energy at the start.
    pub initial_energy: Energy,
    /// Energy at the end.
    pub final_energy: Energy,
    /// Energy dissipated over the run, and work put in by forces without a potential (J).
    pub exchange: Exchange,
    /// Largest deviation of the total energy, plus what was dissipated, less what was put in, from its start, relative to
    /// the largest kinetic energy seen.
    pub max_relative_energy_error: f64,
    /// Largest violation of any constraint at the end of any step.
    pub max_violation: Violation,
}

/// How a run ended.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The integrator gave up.
    #[error(transparent)]
    Step(#[from] StepError),
    /// An observer gave up.
    #[error(transparent)]
    Observer(ObserverError),
    /// The interrupt flag was set.
    #[error("interrupted at t = {time} s")]
    Interrupted { time: f64 },
}

/// Runs `integrator` from `state` for `options.duration` and shows it to the observers.
///
/// The summary is filled in up to where the run ended, also when it ended in an error.
pub fn run(
    mechanism: &Mechanism,
    state: &mut State,
    integrator: &mut dyn Integrator,
    options: &RunOptions,
    observers: &mut [&mut dyn Observer],
) -> (Summary, Result<(), RunError>) {
    let mut course = Course::new(mechanism, state, options.duration, options.rate);
    let ended = course
        .begin(observers)
        .and_then(|()| course.proceed(mechanism, state, integrator, f64::INFINITY, options.interrupt, observers));
    (course.summary(), ended)
}

/// A run that can be halted between steps and taken up again.
pub(crate) struct Course {
    start: f64,
    end: f64,
    rate: Option<f64>,
    /// Samples shown so far.
    sampled: u64,
    position: Vec<f64>,
    velocity: Vec<f64>,
    bodies: Vec<BodyState>,
    /// Time on the wall that the steps of a call of [`Course::proceed`] took.
    solving: Duration,
    bookkeeper: Bookkeeper,
}

impl Course {
    /// A run of `duration` from `state` with `rate` samples a second.
    pub(crate) fn new(mechanism: &Mechanism, state: &State, duration: f64, rate: Option<f64>) -> Self {
        Course {
            start: state.time,
            end: state.time + duration,
            rate,
            sampled: 0,
            position: state.position.clone(),
            velocity: state.velocity.clone(),
            bodies: body_states(mechanism, state),
            solving: Duration::ZERO,
            bookkeeper: Bookkeeper::new(mechanism, state),
        }
    }

    /// The figures so far.
    pub(crate) fn summary(&self) -> Summary {
        self.bookkeeper.summary
    }

    /// The k-th sample is start + k/rate, never an accumulated sum; the last one is the end itself.
    fn sample_time(&self, k: u64) -> f64 {
        match self.rate {
            Some(rate) => (self.start + k as f64 / rate).min(self.end),
            None if k == 0 => self.start,
            None => self.end,
        }
    }

    /// Shows the start.
    pub(crate) fn begin(&mut self, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        self.sampled = 1;
        self.show(self.start, observers)
    }

    /// Makes steps from `state`, where the last call left it, until one ends at or after `horizon` or at the end of the run.
    pub(crate) fn proceed(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        integrator: &mut dyn Integrator,
        horizon: f64,
        interrupt: Option<&AtomicBool>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        let (processor, wall) = (ThreadTime::now(), Instant::now());
        self.solving = Duration::ZERO;
        let ended = self.steps(mechanism, state, integrator, horizon, interrupt, observers);
        let share = self.solving.as_secs_f64() / wall.elapsed().as_secs_f64().max(f64::MIN_POSITIVE);
        self.bookkeeper.summary.solve_cpu_seconds += share.min(1.0) * processor.elapsed().as_secs_f64();
        ended
    }

    /// [`Course::proceed`], with the time spent in the integrator added to `solving`.
    fn steps(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        integrator: &mut dyn Integrator,
        horizon: f64,
        interrupt: Option<&AtomicBool>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        while state.time < self.end && state.time < horizon {
            if interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
                return Err(RunError::Interrupted { time: state.time });
            }
            let clock = Instant::now();
            let outcome = integrator.advance(mechanism, state, self.end);
            self.solving += clock.elapsed();
            let outcome = outcome?;
            forward_kinematics(mechanism, &state.position, &state.velocity, &mut self.bodies);
            self.bookkeeper.record(mechanism, state, &self.bodies, outcome);
            observers.iter_mut().for_each(|observer| observer.step(&self.bookkeeper.last));
            while self.sample_time(self.sampled) <= state.time {
                let time = self.sample_time(self.sampled);
                if time == state.time {
                    self.position.copy_from_slice(&state.position);
                    self.velocity.copy_from_slice(&state.velocity);
                } else {
                    integrator.dense(mechanism, time, &mut self.position, &mut self.velocity);
                }
                self.show(time, observers)?;
                self.sampled += 1;
                if time == self.end {
                    break;
                }
            }
        }
        Ok(())
    }

    fn show(&self, time: f64, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        let Course { position, velocity, .. } = self;
        show(observers, &Sample { time, position, velocity, step: &self.bookkeeper.last })
    }
}

/// Shows a sample to every observer.
pub(crate) fn show(observers: &mut [&mut dyn Observer], sample: &Sample) -> Result<(), RunError> {
    observers.iter_mut().try_for_each(|observer| observer.sample(sample)).map_err(RunError::Observer)
}

/// Collects the figures of the run.
struct Bookkeeper {
    summary: Summary,
    last: StepEnd,
    largest_kinetic: f64,
    largest_deviation: f64,
    /// What rounding has cut off the sums of dissipated energy and work.
    rest: Exchange,
}

impl Bookkeeper {
    fn new(mechanism: &Mechanism, state: &State) -> Self {
        let mut bodies = vec![WORLD; mechanism.bodies.len()];
        forward_kinematics(mechanism, &state.position, &state.velocity, &mut bodies);
        let initial = energy_with_forces(mechanism, &state.position, &bodies);
        let violation = violation(mechanism, &bodies);
        Bookkeeper {
            summary: Summary {
                initial_energy: initial,
                final_energy: initial,
                max_violation: violation,
                ..Summary::default()
            },
            last: StepEnd {
                time: state.time,
                energy: initial,
                exchange: Exchange::default(),
                violation,
                outcome: StepOutcome::default(),
                so_far: Counts::default(),
            },
            largest_kinetic: initial.kinetic,
            largest_deviation: 0.0,
            rest: Exchange::default(),
        }
    }

    fn record(&mut self, mechanism: &Mechanism, state: &State, bodies: &[BodyState], outcome: StepOutcome) {
        let energy = energy_with_forces(mechanism, &state.position, bodies);
        let violation = violation(mechanism, bodies);
        let summary = &mut self.summary;
        add(&mut summary.exchange.dissipated, &mut self.rest.dissipated, outcome.exchange.dissipated);
        add(&mut summary.exchange.work, &mut self.rest.work, outcome.exchange.work);
        let exchange = summary.exchange;
        summary.steps += 1;
        summary.iterations += outcome.iterations;
        summary.rejected_steps += outcome.rejected;
        let so_far = Counts { steps: summary.steps, iterations: summary.iterations, rejected: summary.rejected_steps };
        self.last = StepEnd { time: state.time, energy, exchange, violation, outcome, so_far };
        summary.final_energy = energy;
        summary.max_violation.position = summary.max_violation.position.max(violation.position);
        summary.max_violation.velocity = summary.max_violation.velocity.max(violation.velocity);
        self.largest_kinetic = self.largest_kinetic.max(energy.kinetic);
        let balance = energy.total() - summary.initial_energy.total() + (exchange.dissipated - exchange.work);
        self.largest_deviation = self.largest_deviation.max(balance.abs());
        summary.max_relative_energy_error = if self.largest_kinetic > 0.0 {
            self.largest_deviation / self.largest_kinetic
        } else {
            self.largest_deviation
        };
    }
}

/// `sum += term`, compensated (Kahan).
fn add(sum: &mut f64, rest: &mut f64, term: f64) {
    let wanted = term + *rest;
    let next = *sum + wanted;
    *rest = wanted - (next - *sum);
    *sum = next;
}

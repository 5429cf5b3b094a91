//! Runs of independent mechanisms side by side: each island with its own integrator, and those at rest not at all.
//!
//! Nothing couples the islands ([`crate::model::islands`]), so each is run as if it were alone, by the same loop
//! ([`crate::simulation`]), with its own steps; what they show is put together afterwards in order of time:
//!
//! - a sample of the whole is one of every island at the same instant, from its own dense output;
//! - the figures of a run add up over the ends of all steps of all islands: the energy balance at an instant is the sum of the
//!   balances at each island's last step;
//! - the figures that go with a sample are of that instant, because no step of all islands ends there.
//!
//! Islands advance in windows of simulated time, several at once on as many threads as there are. An island sees neither the
//! windows nor the others, and the order of putting together is that of time and number; so every result is the same, bit
//! for bit, whatever the windows and the number of threads.

use crate::forces::total::Exchange;
use crate::invariants::{energy_with_forces, violation};
use crate::kinematics::{WORLD, forward_kinematics};
use crate::lobatto::Lobatto;
use crate::model::{Island, Mechanism, Rule, islands};
use crate::rest::is_at_rest;
use crate::simulation::{
    Counts, Course, FrequencyStep, Integrator, MethodDescription, Observer, ObserverError, RunError, RunOptions,
    Sample, StepEnd, StepOutcome, Summary, show,
};
use crate::state::{BodyState, State};
use std::collections::VecDeque;
use std::num::NonZero;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// A window should take this long (s of wall time): long against starting threads, short against a user's patience.
const WINDOW: f64 = 0.02;
/// Windows that take less than this (s) do not pay for threads, each of which takes some 50 µs to start and join.
const WORTH_THREADS: f64 = 1e-3;
/// The first window is this part of the run.
const FIRST_WINDOW: f64 = 1.0 / 1024.0;
/// Where nobody wants samples the run is sampled so often all the same, so that one that fails has a last state.
const CHECKPOINTS: f64 = 16.0;

/// What a mechanism falls into.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The islands, and whether each sleeps.
    pub islands: Vec<(Island, bool)>,
}

impl Plan {
    /// Applies the rules, except for those that are switched off.
    pub fn new(mechanism: &Mechanism, state: &State, switched_off: &[Rule]) -> Self {
        let all =
            if switched_off.contains(&Rule::Islands) { vec![Island::whole(mechanism)] } else { islands(mechanism) };
        let sleeps = |island: &Island| {
            !switched_off.contains(&Rule::Sleep) && is_at_rest(&island.mechanism, &island.state(state))
        };
        let with_sleep = |island: Island| {
            let asleep = sleeps(&island);
            (island, asleep)
        };
        Plan { islands: all.into_iter().map(with_sleep).collect() }
    }

    /// Whether no rule applies: the mechanism is one, and it moves.
    pub fn is_whole(&self) -> bool {
        self.islands.len() < 2 && self.sleeping() == 0
    }

    /// How many islands sleep.
    pub fn sleeping(&self) -> usize {
        self.islands.iter().filter(|(_, asleep)| *asleep).count()
    }
}

/// On how many threads islands are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Threads {
    /// As many as there are processors, where the work pays for them.
    WherePaid,
    /// So many, always.
    Exactly(usize),
}

/// The integrators of all islands of a mechanism.
pub struct Islands {
    parts: Vec<Part>,
    threads: Threads,
}

/// An island and how it is run.
struct Part {
    island: Island,
    state: State,
    /// `None` if it sleeps.
    awake: Option<Lobatto>,
    course: Option<Course>,
    /// What it has shown and nobody has taken yet.
    shown: Shown,
    /// Its kinetic energy, and what its energy balance is off by, at the last step that was taken (J).
    kinetic: f64,
    deviation: f64,
    /// Its total energy at the start (J).
    initial: f64,
    /// Energy dissipated since the start of the run, and work put in, up to that step (J).
    exchange: Exchange,
    /// Steps that were taken, and their iterations.
    steps: usize,
    iterations: usize,
    failed: Option<RunError>,
}

/// What a run did, for the report.
pub struct IslandFigures<'i> {
    /// The island.
    pub island: &'i Island,
    /// How it was integrated; `None` if it slept.
    pub method: Option<MethodDescription>,
    /// Accepted steps.
    pub steps: usize,
    /// Their iterations.
    pub iterations: usize,
}

/// Samples and steps of one island, in order.
#[derive(Default)]
struct Shown {
    samples: VecDeque<Kept>,
    steps: VecDeque<StepEnd>,
}

/// A sample of one island.
struct Kept {
    time: f64,
    position: Vec<f64>,
    velocity: Vec<f64>,
    bodies: Vec<BodyState>,
}

impl Observer for Shown {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let (position, velocity, bodies) = (sample.position.to_vec(), sample.velocity.to_vec(), sample.bodies.to_vec());
        self.samples.push_back(Kept { time: sample.time, position, velocity, bodies });
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        self.steps.push_back(*end);
    }
}

impl Threads {
    fn at_most(self) -> usize {
        match self {
            Threads::WherePaid => std::thread::available_parallelism().map_or(1, NonZero::get),
            Threads::Exactly(count) => count,
        }
    }

    /// For work that is expected to take so many seconds on one of them.
    fn for_work_of(self, seconds: f64) -> usize {
        if self == Threads::WherePaid && seconds < WORTH_THREADS { 1 } else { self.at_most() }
    }
}

impl Islands {
    /// Makes the integrators of the islands that are awake, each with a note for the caller; the notes are in the order of these
    /// islands. `expected` is about how long that will take (s), which decides whether it is done on several threads.
    ///
    /// # Errors
    /// The first error of `make`, in the order of the islands.
    pub fn new<N: Send, E: Send>(
        plan: Plan,
        state: &State,
        threads: Threads,
        expected: f64,
        make: impl Fn(&Mechanism, &State) -> Result<(Lobatto, N), E> + Sync,
    ) -> Result<(Self, Vec<N>), E> {
        let mut jobs: Vec<(Part, bool, Option<Result<N, E>>)> =
            plan.islands.into_iter().map(|(island, asleep)| (Part::new(island, state), asleep, None)).collect();
        spread(&mut jobs, threads.for_work_of(expected), |(part, asleep, note)| {
            if *asleep {
                return;
            }
            *note = Some(make(&part.island.mechanism, &part.state).map(|(lobatto, note)| {
                part.awake = Some(lobatto);
                note
            }));
        });
        let mut parts = Vec::with_capacity(jobs.len());
        let mut notes = Vec::new();
        for (part, _, note) in jobs {
            if let Some(note) = note {
                notes.push(note?);
            }
            parts.push(part);
        }
        Ok((Islands { parts, threads }, notes))
    }

    /// What the islands that are awake are integrated with, together; `None` if all sleep.
    ///
    /// Stages are the most that any has, the step is the mean over all, and the nearest to the limit of stability counts.
    pub fn description(&self) -> Option<MethodDescription> {
        let mut all = self.parts.iter().filter_map(|part| Some((part.awake.as_ref()?.description(), part.steps)));
        let (mut together, mut steps) = all.next()?;
        let mut stepped = together.step * steps as f64;
        for (one, count) in all {
            together.stages = together.stages.max(one.stages);
            together.order = together.order.max(one.order);
            steps += count;
            stepped += one.step * count as f64;
            let share = |seen: &FrequencyStep| seen.product / seen.limit;
            together.frequency_step = together
                .frequency_step
                .into_iter()
                .chain(one.frequency_step)
                .max_by(|a, b| share(a).total_cmp(&share(b)));
            together.singular = together.singular.into_iter().chain(one.singular).max_by_key(|seen| seen.extra);
            together.reversible_resets = together.reversible_resets.zip(one.reversible_resets).map(|(a, b)| a + b);
        }
        if steps > 0 {
            together.step = stepped / steps as f64;
        }
        Some(together)
    }

    /// What each island did.
    pub fn figures(&self) -> impl Iterator<Item = IslandFigures<'_>> {
        self.parts.iter().map(|part| IslandFigures {
            island: &part.island,
            method: part.awake.as_ref().map(Integrator::description),
            steps: part.steps,
            iterations: part.iterations,
        })
    }

    /// Runs all islands from where they are for `options.duration`, and shows the whole to the observers.
    ///
    /// `state` is moved to the end of the run, or, if it ends early, to the last sample that all islands have reached. The summary
    /// is filled in up to there.
    pub fn run(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
    ) -> (Summary, Result<(), RunError>) {
        let mut whole = Whole::new(mechanism, state, options);
        self.parts.iter_mut().for_each(|part| part.state = part.island.state(state));
        let ended = self.drive(mechanism, options, observers, &mut whole);
        whole.summary.solve_cpu_seconds =
            self.parts.iter().filter_map(|part| Some(part.course.as_ref()?.summary().solve_cpu_seconds)).sum();
        if ended.is_ok() {
            for Part { island, state: own, .. } in &self.parts {
                island.put(&own.position, &mut state.position, |piece| &piece.positions);
                island.put(&own.compensation, &mut state.compensation, |piece| &piece.positions);
                island.put(&own.velocity, &mut state.velocity, |piece| &piece.velocities);
            }
            state.time = whole.end;
        } else {
            state.position.copy_from_slice(&whole.position);
            state.velocity.copy_from_slice(&whole.velocity);
            state.compensation.fill(0.0);
            state.time = whole.time;
        }
        forward_kinematics(mechanism, &state.position, &state.velocity, &mut whole.bodies);
        whole.summary.final_energy = energy_with_forces(mechanism, &state.position, &whole.bodies);
        (whole.summary, ended)
    }

    fn drive(
        &mut self,
        mechanism: &Mechanism,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
        whole: &mut Whole,
    ) -> Result<(), RunError> {
        let rate = options.rate.unwrap_or(CHECKPOINTS / options.duration);
        for part in &mut self.parts {
            part.begin(options.duration, rate)?;
        }
        let mut awake: Vec<&mut Part> = self.parts.iter_mut().filter(|part| part.awake.is_some()).collect();
        if awake.is_empty() {
            return whole.show_rest(mechanism, options, observers);
        }
        whole.take(mechanism, &mut awake, observers)?;
        let mut window = FIRST_WINDOW * options.duration;
        let mut took = 0.0;
        while frontier(&awake) < whole.end {
            let horizon = frontier(&awake) + window;
            let clock = Instant::now();
            let threads = self.threads.for_work_of(took);
            // The largest first, so that none of them is left for the end.
            awake.sort_by_key(|part| std::cmp::Reverse(part.island.mechanism.bodies.len()));
            spread(&mut awake, threads, |part| part.proceed(horizon, options));
            awake.sort_by_key(|part| part.island.pieces.first().map(|piece| piece.bodies.start));
            took = clock.elapsed().as_secs_f64();
            whole.take(mechanism, &mut awake, observers)?;
            if let Some(error) = first_error(&mut awake) {
                return Err(match error {
                    RunError::Interrupted { .. } => RunError::Interrupted { time: whole.time },
                    error => error,
                });
            }
            window *= if took < 0.5 * WINDOW { 2.0 } else { (WINDOW / took).max(0.25) };
        }
        Ok(())
    }
}

impl Part {
    fn new(island: Island, whole: &State) -> Self {
        Part {
            state: island.state(whole),
            island,
            awake: None,
            course: None,
            shown: Shown::default(),
            kinetic: 0.0,
            deviation: 0.0,
            initial: 0.0,
            exchange: Exchange::default(),
            steps: 0,
            iterations: 0,
            failed: None,
        }
    }

    /// Prepares a run from where it is.
    fn begin(&mut self, duration: f64, rate: f64) -> Result<(), RunError> {
        if self.awake.is_none() {
            return Ok(());
        }
        let mut course = Course::new(&self.island.mechanism, &self.state, duration, Some(rate));
        let initial = course.summary().initial_energy;
        (self.kinetic, self.deviation, self.initial) = (initial.kinetic, 0.0, initial.total());
        (self.exchange, self.steps, self.iterations, self.failed) = (Exchange::default(), 0, 0, None);
        self.shown = Shown::default();
        course.begin(&mut [&mut self.shown])?;
        self.course = Some(course);
        Ok(())
    }

    /// Makes steps until one ends at or after `horizon`; a failure is kept.
    fn proceed(&mut self, horizon: f64, options: &RunOptions) {
        let Part { island, state, awake: Some(lobatto), course: Some(course), shown, failed, .. } = self else {
            return;
        };
        let ended = course.proceed(&island.mechanism, state, lobatto, horizon, options.interrupt, &mut [shown]);
        *failed = ended.err();
    }

    /// Takes over the figures of its next step.
    fn take(&mut self, end: &StepEnd) {
        self.kinetic = end.energy.kinetic;
        self.exchange = end.exchange;
        self.deviation = end.energy.total() - self.initial + (end.exchange.dissipated - end.exchange.work);
        self.steps += 1;
        self.iterations += end.outcome.iterations;
    }
}

/// Up to where all islands that are awake have come (s).
fn frontier(awake: &[&mut Part]) -> f64 {
    awake.iter().map(|part| part.state.time).fold(f64::INFINITY, f64::min)
}

/// The failure at the earliest time; an interruption counts only if nothing failed.
fn first_error(awake: &mut [&mut Part]) -> Option<RunError> {
    let interrupted = |part: &Part| matches!(part.failed, Some(RunError::Interrupted { .. }));
    let failed = awake.iter_mut().filter(|part| part.failed.is_some());
    let first = failed.min_by(|a, b| interrupted(a).cmp(&interrupted(b)).then(a.state.time.total_cmp(&b.state.time)));
    first.and_then(|part| part.failed.take())
}

/// Does the work on every item, on so many threads at most.
fn spread<T: Send>(items: &mut [T], threads: usize, work: impl Fn(&mut T) + Sync) {
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

/// The run of the whole, put together from those of the islands.
struct Whole {
    start: f64,
    end: f64,
    /// Whether samples inside the run are wanted.
    sampled: bool,
    /// Time of the last sample, and what it was.
    time: f64,
    position: Vec<f64>,
    velocity: Vec<f64>,
    bodies: Vec<BodyState>,
    summary: Summary,
    /// Sums over the islands at the last step that was taken (J).
    kinetic: f64,
    deviation: f64,
    exchange: Exchange,
    largest_kinetic: f64,
    largest_deviation: f64,
    /// What the steps since the last sample have cost together, and how many steps had been made up to there.
    since: StepOutcome,
    steps_before: usize,
    /// Steps to be taken, with the numbers of their islands.
    waiting: Vec<(StepEnd, usize)>,
}

impl Whole {
    fn new(mechanism: &Mechanism, state: &State, options: &RunOptions) -> Self {
        let mut bodies = vec![WORLD; mechanism.bodies.len()];
        forward_kinematics(mechanism, &state.position, &state.velocity, &mut bodies);
        let initial = energy_with_forces(mechanism, &state.position, &bodies);
        Whole {
            start: state.time,
            end: state.time + options.duration,
            sampled: options.rate.is_some(),
            time: state.time,
            position: state.position.clone(),
            velocity: state.velocity.clone(),
            summary: Summary {
                initial_energy: initial,
                final_energy: initial,
                max_violation: violation(mechanism, &bodies),
                ..Summary::default()
            },
            bodies,
            kinetic: initial.kinetic,
            deviation: 0.0,
            exchange: Exchange::default(),
            largest_kinetic: initial.kinetic,
            largest_deviation: 0.0,
            since: StepOutcome::default(),
            steps_before: 0,
            waiting: Vec::new(),
        }
    }

    /// Takes everything up to where all islands have come, in order of time.
    fn take(
        &mut self,
        mechanism: &Mechanism,
        awake: &mut [&mut Part],
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        loop {
            let ready = awake.iter().all(|part| !part.shown.samples.is_empty());
            let until = match awake.first().and_then(|part| part.shown.samples.front()) {
                Some(sample) if ready => sample.time,
                _ => frontier(awake),
            };
            self.take_steps(awake, until);
            if !ready {
                return Ok(());
            }
            for Part { island, shown, .. } in awake.iter_mut().map(|part| &mut **part) {
                let Some(sample) = shown.samples.pop_front() else { continue };
                island.put(&sample.position, &mut self.position, |piece| &piece.positions);
                island.put(&sample.velocity, &mut self.velocity, |piece| &piece.velocities);
                island.put(&sample.bodies, &mut self.bodies, |piece| &piece.bodies);
            }
            self.time = until;
            self.show(mechanism, observers)?;
        }
    }

    /// Takes all steps that end at or before `until`.
    fn take_steps(&mut self, awake: &mut [&mut Part], until: f64) {
        for (number, part) in awake.iter_mut().enumerate() {
            let steps = &mut part.shown.steps;
            let count = steps.partition_point(|end| end.time <= until);
            self.waiting.extend(steps.drain(..count).map(|end| (end, number)));
        }
        // Stable: what ends at the same time stays in the order of the islands.
        self.waiting.sort_by(|(a, _), (b, _)| a.time.total_cmp(&b.time));
        for (index, (end, number)) in self.waiting.iter().enumerate() {
            let part = &mut awake[*number];
            let before = (part.kinetic, part.deviation, part.exchange);
            part.take(end);
            self.kinetic += part.kinetic - before.0;
            self.deviation += part.deviation - before.1;
            self.exchange.dissipated += part.exchange.dissipated - before.2.dissipated;
            self.exchange.work += part.exchange.work - before.2.work;
            let summary = &mut self.summary;
            summary.steps += 1;
            summary.iterations += end.outcome.iterations;
            summary.rejected_steps += end.outcome.rejected;
            summary.max_violation.position = summary.max_violation.position.max(end.violation.position);
            summary.max_violation.velocity = summary.max_violation.velocity.max(end.violation.velocity);
            self.since.step += end.outcome.step;
            self.since.iterations += end.outcome.iterations;
            self.since.rejected += end.outcome.rejected;
            self.since.exchange.dissipated += end.outcome.exchange.dissipated;
            self.since.exchange.work += end.outcome.exchange.work;
            // Balances belong together when all that end at the same time have been taken.
            if self.waiting.get(index + 1).is_none_or(|(next, _)| next.time > end.time) {
                self.largest_kinetic = self.largest_kinetic.max(self.kinetic);
                self.largest_deviation = self.largest_deviation.max(self.deviation.abs());
            }
        }
        self.waiting.clear();
        let scale = if self.largest_kinetic > 0.0 { self.largest_kinetic } else { 1.0 };
        self.summary.max_relative_energy_error = self.largest_deviation / scale;
        self.summary.exchange = self.exchange;
    }

    /// Shows the last sample, if it is wanted, with the figures of its instant.
    fn show(&mut self, mechanism: &Mechanism, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        let wanted = self.sampled || self.time == self.start || self.time == self.end;
        if observers.is_empty() || !wanted {
            return Ok(());
        }
        let mut outcome = std::mem::take(&mut self.since);
        let Summary { steps, iterations, rejected_steps: rejected, .. } = self.summary;
        outcome.step /= (steps - std::mem::replace(&mut self.steps_before, steps)).max(1) as f64;
        let step = StepEnd {
            time: self.time,
            energy: energy_with_forces(mechanism, &self.position, &self.bodies),
            exchange: self.exchange,
            violation: violation(mechanism, &self.bodies),
            outcome,
            so_far: Counts { steps, iterations, rejected },
        };
        let Whole { time, position, velocity, bodies, .. } = &*self;
        show(observers, &Sample { time: *time, position, velocity, bodies, step: &step })
    }

    /// Shows a run in which nothing moves.
    fn show_rest(
        &mut self,
        mechanism: &Mechanism,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        self.show(mechanism, observers)?;
        let mut samples = 0_u64;
        while self.time < self.end {
            if options.interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
                return Err(RunError::Interrupted { time: self.time });
            }
            samples += 1;
            self.time = options.rate.map_or(self.end, |rate| (self.start + samples as f64 / rate).min(self.end));
            self.show(mechanism, observers)?;
        }
        Ok(())
    }
}

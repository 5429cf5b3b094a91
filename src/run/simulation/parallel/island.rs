//! One island of a run: its own loop, and its samples and events until the other islands have reached the same time.

use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::energy::Energy;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;
use crate::mechanism::structure::islands::Island;
use crate::simulation::parallel::between::Knot;
use crate::simulation::steps::course::{Aim, Course, RunError, RunOptions};
use crate::simulation::steps::observer::{Observer, ObserverError, Sample, StepEnd};
use crate::simulation::tolerance::accuracy_so_far::AccuracySoFar;
use crate::simulation::tolerance::estimated_run::EstimatedRun;
use std::collections::VecDeque;

/// An island and its run.
pub(crate) struct IslandRun<'a> {
    pub(crate) island: Island,
    pub(crate) state: State,
    /// External efforts on its joints [N m or N]: empty, or one per degree of freedom.
    pub(crate) efforts: Vec<f64>,
    /// `None` if it sleeps.
    pub(crate) awake: Option<EstimatedRun<'a>>,
    pub(crate) course: Option<Course>,
    /// Samples and steps that have not been taken over yet.
    pub(crate) shown: Shown,
    /// The end of the last step taken over, the last sample taken over, and the energies there once they were asked for.
    pub(crate) last: Knot,
    pub(crate) last_sample: Option<Kept>,
    pub(crate) at_sample: Option<Knot>,
    /// The error of its energy balance at the last step taken over (J).
    pub(crate) deviation: f64,
    /// Its energies at the start (J).
    pub(crate) initial: Energy,
    /// The accuracy that it has told up to that step.
    pub(crate) so_far: Option<AccuracySoFar>,
    /// Steps taken over, and their iterations.
    pub(crate) steps: usize,
    pub(crate) iterations: usize,
    failed: Option<RunError>,
}

/// Samples and steps of one island, in order.
#[derive(Default)]
pub(crate) struct Shown {
    pub(crate) samples: VecDeque<Kept>,
    pub(crate) steps: VecDeque<StepEnd>,
    pub(crate) events: VecDeque<Event>,
    pub(crate) told: VecDeque<AccuracySoFar>,
    /// The contacts of the next sample, and the efforts that motors hold there.
    contacts: Vec<ContactPoint>,
    held: Vec<Option<f64>>,
}

/// A sample of one island.
pub(crate) struct Kept {
    pub(crate) time: f64,
    pub(crate) position: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) contacts: Vec<ContactPoint>,
    /// An entry a motor of the island, or empty.
    pub(crate) held: Vec<Option<f64>>,
}

impl Kept {
    /// Its state, without the rounded-off parts of positions.
    fn state(&self) -> State {
        let Kept { time, position, velocity, .. } = self;
        let compensation = vec![0.0; position.len()];
        State { time: *time, position: position.clone(), velocity: velocity.clone(), compensation }
    }
}

impl Observer for Shown {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let (position, velocity) = (sample.position.to_vec(), sample.velocity.to_vec());
        let (contacts, held) = (std::mem::take(&mut self.contacts), std::mem::take(&mut self.held));
        self.samples.push_back(Kept { time: sample.time, position, velocity, contacts, held });
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        self.steps.push_back(*end);
    }

    fn event(&mut self, event: &Event) {
        self.events.push_back(*event);
    }

    fn accuracy(&mut self, so_far: &AccuracySoFar) {
        self.told.push_back(*so_far);
    }

    fn contacts(&mut self, points: &[ContactPoint]) {
        self.contacts.clear();
        self.contacts.extend_from_slice(points);
    }

    fn held_efforts(&mut self, efforts: &[Option<f64>]) {
        self.held.clear();
        self.held.extend_from_slice(efforts);
    }
}

impl IslandRun<'_> {
    pub(crate) fn new(island: Island, whole: &State) -> Self {
        IslandRun {
            state: island.state(whole),
            island,
            efforts: Vec::new(),
            awake: None,
            course: None,
            shown: Shown::default(),
            last: Knot { time: whole.time, energy: Energy::default(), exchange: Exchange::default() },
            last_sample: None,
            at_sample: None,
            deviation: 0.0,
            initial: Energy::default(),
            so_far: None,
            steps: 0,
            iterations: 0,
            failed: None,
        }
    }

    /// Prepares a run from the present state.
    pub(crate) fn begin(&mut self, duration: f64, rate: f64) -> Result<(), RunError> {
        if self.awake.is_none() {
            return Ok(());
        }
        let mut course = Course::new(&self.island.mechanism, &self.state, duration, Some(rate));
        let initial = course.summary().initial_energy;
        self.last = Knot { time: self.state.time, energy: initial, exchange: Exchange::default() };
        (self.last_sample, self.at_sample) = (None, None);
        (self.deviation, self.initial) = (0.0, initial);
        (self.steps, self.iterations, self.failed) = (0, 0, None);
        (self.shown, self.so_far) = (Shown::default(), None);
        course.begin(&self.island.mechanism, &mut [&mut self.shown])?;
        self.course = Some(course);
        Ok(())
    }

    /// Makes steps as far as the aim, and keeps an error.
    pub(crate) fn proceed(&mut self, aim: Aim, options: &RunOptions) {
        let IslandRun { island, state, efforts, awake: Some(integrator), course: Some(course), shown, failed, .. } =
            self
        else {
            return;
        };
        let inputs = Inputs::constant(efforts);
        let ended = course.proceed(&island.mechanism, inputs, state, integrator, aim, options.interrupt, &mut [shown]);
        *failed = ended.err();
    }

    /// Takes over the figures of its next step.
    pub(crate) fn take(&mut self, end: &StepEnd) {
        self.last = Knot::after(end);
        self.deviation = end.energy.total() - self.initial.total() + end.exchange.lost();
        self.steps += 1;
        self.iterations += end.outcome.cost.iterations;
    }

    /// Its energies at a time (s) between the last step taken over and the `next` one, if there is one.
    pub(crate) fn between(&mut self, time: f64, next: Option<&StepEnd>) -> Knot {
        if self.last.time >= time {
            return self.last;
        }
        let mechanism = &self.island.mechanism;
        let sampled = self.last_sample.as_ref();
        if self.at_sample.is_none() {
            self.at_sample = sampled.map(|kept| Knot::of_sample(mechanism, &kept.state()));
        }
        let earlier = self.at_sample.filter(|sample| sample.time > self.last.time).unwrap_or(self.last);
        let step = next.map_or(self.last, Knot::before);
        let sample = self.shown.samples.front().filter(|sample| sample.time < step.time);
        let later = sample.map_or(step, |kept| Knot::of_sample(mechanism, &kept.state()));
        Knot { exchange: self.last.towards(&step, time).exchange, ..earlier.towards(&later, time) }
    }
}

/// Puts the efforts of the motors of an island in their places of the whole, which has its motors in the same order.
pub(crate) fn put_held(island: &Island, own: &[Option<f64>], motors: &[Motor], whole: &mut [Option<f64>]) {
    let mut rest = motors.iter().zip(whole);
    for (motor, effort) in island.mechanism.nonsmooth.motors.iter().zip(own) {
        let body = island.body_of_whole(motor.coordinate.body);
        if let Some((_, held)) = rest.find(|(motor, _)| motor.coordinate.body == body) {
            *held = *effort;
        }
    }
}

/// The time that all awake islands have reached (s).
pub(crate) fn frontier(awake: &[&mut IslandRun]) -> f64 {
    awake.iter().map(|part| part.state.time).fold(f64::INFINITY, f64::min)
}

/// The failure at the earliest time; an interruption counts only if no island failed.
pub(crate) fn first_error(awake: &mut [&mut IslandRun]) -> Option<RunError> {
    let interrupted = |part: &IslandRun| matches!(part.failed, Some(RunError::Interrupted { .. }));
    let failed = awake.iter_mut().filter(|part| part.failed.is_some());
    let first = failed.min_by(|a, b| interrupted(a).cmp(&interrupted(b)).then(a.state.time.total_cmp(&b.state.time)));
    first.and_then(|part| part.failed.take())
}

//! One island of a run: its own loop, and its samples and events until the other islands have reached the same time.

use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::energy::Energy;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::Integrator;
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

impl<'a> IslandRun<'a> {
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

    /// Gives it its efforts of those on the whole.
    pub(crate) fn set_efforts(&mut self, whole: &[f64]) {
        self.efforts.clear();
        let freedoms = self.island.pieces.iter().map(|piece| piece.velocities.clone());
        freedoms.for_each(|freedoms| self.efforts.extend_from_slice(&whole[freedoms]));
    }

    /// Gives its motor along this freedom of the whole a target from now on, if it has such a motor.
    pub(crate) fn aim(&mut self, freedom: usize, value: f64) {
        let mut local = 0;
        for piece in &self.island.pieces {
            if piece.velocities.contains(&freedom) {
                let own = local + freedom - piece.velocities.start;
                let motors = &self.island.mechanism.nonsmooth.motors;
                let motor = motors.iter().position(|motor| motor.coordinate.freedom == own);
                // An island with a motor never sleeps.
                if let (Some(motor), Some(run)) = (motor, &mut self.awake) {
                    run.aim(motor, value);
                }
            }
            local += piece.velocities.len();
        }
    }

    /// Puts the efforts that its sampled motors hold from the present state on in their places of the whole, an entry a motor.
    pub(crate) fn put_held(&self, motors: &[Motor], whole: &mut [Option<f64>]) {
        let mut own = Vec::new();
        self.awake.iter().for_each(|run| run.held_efforts(false, &mut own));
        put_held(&self.island, &own, motors, whole);
    }

    /// Prepares a run from the present state whose samples are those of a run that began at `start` (s).
    pub(crate) fn begin_within(&mut self, start: f64, duration: f64, rate: f64) -> Result<(), RunError> {
        let now = std::mem::replace(&mut self.state.time, start);
        let begun = self.begin(duration, rate);
        self.shown.samples.clear();
        self.state.time = now;
        self.last.time = now;
        if let Some(course) = &mut self.course {
            course.skip_to(now);
        }
        begun
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
        self.deviation = end.deviation;
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

//! The loop of a run: it makes steps, takes samples inside them, and passes both to the observers.

use crate::events::first_contacts::first_contacts;
use crate::instant::moved::Moved;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::ground::words::short;
use crate::mechanism::motion::contact_point::{ContactFigures, ContactPoint};
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Integrator, StepError, StepOutcome};
use crate::mechanism::motion::kinematics::{body_states, place_bodies};
use crate::mechanism::motion::state::State;
use crate::reduced::ode::joint_of_entry;
use crate::simulation::steps::clock::Clock;
use crate::simulation::steps::observer::{Observer, ObserverError, Sample, any_looks_at_contacts, show};
use crate::simulation::steps::summary::{Bookkeeper, KEPT_EVENTS, Summary};
use crate::simulation::steps::undefined::{beyond, undefined};
use crate::simulation::steps::way::Way;
use crate::simulation::tolerance::accuracy_so_far::{AccuracySoFar, Tells};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The duration and the sampling of a run.
pub struct RunOptions<'o> {
    /// Simulated time to run (s).
    pub duration: f64,
    /// Samples per simulated second, `None` for the first and the last instant only.
    pub rate: Option<f64>,
    /// A flag that ends the run after the current step when it is set.
    pub interrupt: Option<&'o AtomicBool>,
}

/// How a run ended.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The integrator failed.
    #[error(transparent)]
    Step(#[from] StepError),
    /// An observer failed.
    #[error(transparent)]
    Observer(ObserverError),
    /// The interrupt flag was set.
    #[error("interrupted at t = {time} s")]
    Interrupted { time: f64 },
    /// A formula of time has no finite value or rate somewhere before the end.
    #[error(
        "{of} has a formula without a finite value or rate at t = {} s: end the run before, or give a formula that is finite until its end",
        short(*.time)
    )]
    Undefined { of: String, time: f64 },
    /// A winch pays out more than there is of its rope, or less than nothing.
    #[error(
        "{joint:?} leaves the range from 0 to its longest at t = {} s: end the run before, or give the rope a larger longest",
        short(*.time)
    )]
    PaidOut { joint: String, time: f64 },
    /// The steps were too coarse: [`Simulation::run`](crate::simulation::Simulation::run) restarts the run with finer ones.
    #[error("at t = {time} s the estimated error exceeds the tolerance")]
    BeginsAgain { time: f64 },
}

/// The first joint with a position or velocity that is no finite number.
fn joint_not_finite(mechanism: &Mechanism, state: &State) -> Option<String> {
    let bad = state.position.iter().chain(&state.velocity).position(|value| !value.is_finite())?;
    Some(joint_of_entry(mechanism, bad))
}

/// Runs `integrator` from `state` for `options.duration` and calls the observers.
///
/// The summary is filled in up to the end of the run, also after an error.
pub fn run(
    mechanism: &Mechanism,
    state: &mut State,
    integrator: &mut dyn Integrator,
    options: &RunOptions,
    observers: &mut [&mut dyn Observer],
) -> (Summary, Result<(), RunError>) {
    let mut course = Course::new(mechanism, state, options.duration, options.rate);
    let ended = course.begin(mechanism, observers).and_then(|()| {
        course.proceed(mechanism, Inputs::NONE, state, integrator, Aim::END, options.interrupt, observers)
    });
    (course.summary(), ended)
}

/// The time at which a run is halted.
#[derive(Clone, Copy)]
pub(crate) struct Aim {
    /// Until a step ends at or after this time (s).
    pub horizon: f64,
    /// No step ends after this time (s), and one ends exactly there.
    pub until: f64,
}

impl Aim {
    /// No halt before the end of the run.
    pub const END: Aim = Aim { horizon: f64::INFINITY, until: f64::INFINITY };
}

/// A run that can be halted between steps and continued.
pub(crate) struct Course {
    start: f64,
    end: f64,
    rate: Option<f64>,
    /// Number of samples so far.
    sampled: u64,
    position: Vec<f64>,
    velocity: Vec<f64>,
    bodies: Vec<BodyState>,
    /// Whether figures are computed: energies, constraint errors and times of steps.
    figures: bool,
    /// Wall time of the steps since [`Course::count_time`] was called last.
    solving: Duration,
    bookkeeper: Bookkeeper,
    /// The events of the last step.
    happened: Vec<Event>,
    /// The first events of the run.
    events: Vec<Event>,
    /// The last accuracy that was passed to the observers.
    told: Option<AccuracySoFar>,
    /// The state of a sample, if there are pairs of shapes that may touch, and its contacts.
    sampled_state: Option<State>,
    contacts: Vec<ContactPoint>,
    /// The efforts that sampled motors hold at a sample, if there are such motors.
    held: Option<Vec<Option<f64>>>,
    /// Figures of the forces at the end of the last step, and the number of first-order steps until then. They count once what is closed
    /// there has lasted: where an event at the same instant opens it again, or a step of first order follows, which has impulses of its own, no such
    /// force has acted.
    not_lasted: (ContactFigures, usize),
    /// How far its bodies have moved, if somebody wants to know.
    way: Option<Way>,
}

impl Course {
    /// A run of `duration` from `state` with `rate` samples a second.
    pub(crate) fn new(mechanism: &Mechanism, state: &State, duration: f64, rate: Option<f64>) -> Self {
        let bodies = body_states(mechanism, state);
        Course {
            start: state.time,
            end: state.time + duration,
            rate,
            sampled: 0,
            position: state.position.clone(),
            velocity: state.velocity.clone(),
            bookkeeper: Bookkeeper::new(mechanism, state, &bodies),
            bodies,
            figures: true,
            solving: Duration::ZERO,
            happened: Vec::new(),
            events: Vec::new(),
            told: None,
            sampled_state: (!mechanism.nonsmooth.pairs.is_empty()).then(|| state.clone()),
            contacts: Vec::new(),
            held: held_at(mechanism, state),
            not_lasted: (ContactFigures::default(), 0),
            way: None,
        }
    }

    /// From this state on, how far bodies move is measured.
    pub(crate) fn measure_way(&mut self, mechanism: &Mechanism, state: &State) {
        match &mut self.way {
            Some(way) => way.begin(mechanism, state),
            none => *none = Some(Way::new(mechanism, state)),
        }
    }

    /// How far they have moved; empty if nobody wanted to know.
    pub(crate) fn moved(&self) -> &[Moved] {
        self.way.as_ref().map_or(&[], |way| way.moved())
    }

    /// Disables the figures: figures of steps that observers receive keep their values at the start.
    pub(crate) fn without_figures(self) -> Self {
        Course { figures: false, ..self }
    }

    /// The figures so far.
    pub(crate) fn summary(&self) -> Summary {
        let mut summary = self.bookkeeper.summary;
        summary.contact.include(&self.not_lasted.0);
        summary
    }

    /// The k-th sample is at start + k/rate, never at an accumulated sum; the last one is the end itself.
    fn sample_time(&self, k: u64) -> f64 {
        match self.rate {
            Some(rate) => (self.start + k as f64 / rate).min(self.end),
            None if k == 0 => self.start,
            None => self.end,
        }
    }

    /// Passes the start to the observers. Because no step has decided yet which contacts hold there, its contacts are worked out from the state.
    pub(crate) fn begin(&mut self, mechanism: &Mechanism, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        self.sampled = 1;
        if let Some(start) = self.sampled_state.as_ref().filter(|_| any_looks_at_contacts(observers)) {
            let contacts = first_contacts(mechanism, start);
            observers.iter_mut().for_each(|observer| observer.contacts(&contacts));
        }
        if let Some(held) = &self.held {
            observers.iter_mut().for_each(|observer| observer.held_efforts(held));
        }
        self.show(self.start, observers)
    }

    /// Sets the next sample to the first after `time` (s), for an island that starts to move only then.
    pub(crate) fn skip_to(&mut self, time: f64) {
        while self.sample_time(self.sampled) <= time && self.sample_time(self.sampled) < self.end {
            self.sampled += 1;
        }
    }

    /// Makes steps under these inputs from `state`, where the last call stopped, to the aim or the end of the run.
    #[expect(clippy::too_many_arguments, reason = "what is constant, what changes and who watches are apart")]
    pub(crate) fn proceed<I: Integrator + Tells + ?Sized>(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        integrator: &mut I,
        aim: Aim,
        interrupt: Option<&AtomicBool>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        if !self.figures {
            return self.steps(mechanism, inputs, state, integrator, aim, interrupt, observers);
        }
        let clock = Clock::start();
        let ended = self.steps(mechanism, inputs, state, integrator, aim, interrupt, observers);
        self.count_time(&clock);
        ended
    }

    /// Adds the CPU time of the steps since `clock` was started to the summary.
    pub(crate) fn count_time(&mut self, clock: &Clock) {
        self.bookkeeper.summary.solve_cpu_seconds += clock.share(std::mem::take(&mut self.solving));
    }

    /// As [`Course::proceed`]; adds the wall time spent in the integrator to `solving`. The caller calls [`Course::count_time`].
    #[expect(clippy::too_many_arguments, reason = "what is constant, what changes and who watches are apart")]
    pub(crate) fn steps<I: Integrator + Tells + ?Sized>(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        integrator: &mut I,
        aim: Aim,
        interrupt: Option<&AtomicBool>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        let until = self.end.min(aim.until).min(aim.horizon);
        if let Some((of, time)) = undefined(mechanism, state.time, until) {
            return Err(RunError::Undefined { of, time });
        }
        if let Some((joint, time)) = beyond(mechanism, state.time, until) {
            return Err(RunError::PaidOut { joint, time });
        }
        let end = self.end.min(aim.until);
        while state.time < end && state.time < aim.horizon {
            if interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
                return Err(RunError::Interrupted { time: state.time });
            }
            let clock = self.figures.then(Instant::now);
            inputs.check(mechanism, state)?;
            let from = state.time;
            let outcome = integrator.step(mechanism, inputs, state, end);
            self.solving += clock.map_or(Duration::ZERO, |clock| clock.elapsed());
            let outcome = outcome.inspect_err(|_| {
                self.bookkeeper.summary.cost.add(&integrator.take_abandoned());
            })?;
            if let Some(joint) = joint_not_finite(mechanism, state) {
                return Err(StepError::NotFinite { time: from, step: outcome.step, joint }.into());
            }
            if integrator.begins_again() {
                return Err(RunError::BeginsAgain { time: state.time });
            }
            if let Some(way) = &mut self.way {
                way.go_on(mechanism, integrator, from, state);
            }
            self.see_events(integrator, observers);
            if self.figures {
                self.count(mechanism, state, integrator, outcome);
            }
            observers.iter_mut().for_each(|observer| observer.step(&self.bookkeeper.last));
            self.see_accuracy(integrator.so_far(), observers);
            while self.sample_time(self.sampled) <= state.time {
                let time = self.sample_time(self.sampled);
                if time == state.time {
                    self.position.copy_from_slice(&state.position);
                    self.velocity.copy_from_slice(&state.velocity);
                } else {
                    integrator.dense(mechanism, time, &mut self.position, &mut self.velocity);
                }
                self.see_contacts(mechanism, integrator, time, observers);
                if let Some(held) = &mut self.held {
                    held.clear();
                    integrator.held_efforts(time < state.time, held);
                    held.resize(mechanism.nonsmooth.motors.len(), None);
                    observers.iter_mut().for_each(|observer| observer.held_efforts(held));
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

    /// Adds the figures of a step to the summary.
    fn count<I: Integrator + Tells + ?Sized>(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        integrator: &I,
        outcome: StepOutcome,
    ) {
        let bodies = integrator.bodies().unwrap_or_else(|| {
            place_bodies(mechanism, state, &mut self.bodies);
            &self.bodies
        });
        self.bookkeeper.record(mechanism, state, bodies, outcome);
        if self.sampled_state.is_some() {
            self.contacts.clear();
            if !integrator.holds_all(state) {
                integrator.contacts(mechanism, state, &mut self.contacts);
            }
            let mut figures = ContactFigures::default();
            figures.see(state.time, &self.contacts, &mechanism.nonsmooth.pairs);
            figures.penetration = figures.penetration.max(integrator.overlap());
            let of_first_order = || integrator.description().first_order_steps;
            let (before, made) = self.not_lasted;
            let lasted = before.cone_violation > 0.0 && outcome.step > 0.0 && of_first_order() == made;
            let now = figures.of_forces();
            self.not_lasted = (now, if now.cone_violation > 0.0 { of_first_order() } else { 0 });
            let before = if lasted { before } else { ContactFigures::default() };
            let penetration = figures.penetration;
            self.bookkeeper.summary.see_contacts(&ContactFigures { penetration, ..before }, state.time);
        }
    }

    /// Counts the events of the last step, and passes them to the observers.
    fn see_events<I: Integrator + ?Sized>(&mut self, integrator: &mut I, observers: &mut [&mut dyn Observer]) {
        self.happened.clear();
        integrator.take_events(&mut self.happened);
        for event in &self.happened {
            self.bookkeeper.summary.events.count(event.kind);
            if self.events.len() < KEPT_EVENTS {
                self.events.push(*event);
            }
            observers.iter_mut().for_each(|observer| observer.event(event));
        }
    }

    /// Passes the accuracy so far to the observers if it has changed.
    fn see_accuracy(&mut self, so_far: Option<AccuracySoFar>, observers: &mut [&mut dyn Observer]) {
        let Some(told) = so_far.filter(|told| self.told.is_none_or(|before| before != *told)) else { return };
        self.told = so_far;
        observers.iter_mut().for_each(|observer| observer.accuracy(&told));
    }

    /// Passes the contacts at the instant of a sample to the observers.
    fn see_contacts<I: Integrator + ?Sized>(
        &mut self,
        mechanism: &Mechanism,
        integrator: &I,
        time: f64,
        observers: &mut [&mut dyn Observer],
    ) {
        let Some(sample) = self.sampled_state.as_mut().filter(|_| any_looks_at_contacts(observers)) else { return };
        sample.time = time;
        sample.position.copy_from_slice(&self.position);
        sample.velocity.copy_from_slice(&self.velocity);
        sample.compensation.fill(0.0);
        self.contacts.clear();
        integrator.contacts(mechanism, sample, &mut self.contacts);
        observers.iter_mut().for_each(|observer| observer.contacts(&self.contacts));
    }

    /// The first events so far.
    pub(crate) fn events(&self) -> &[Event] {
        &self.events
    }

    fn show(&self, time: f64, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        let Course { position, velocity, .. } = self;
        show(observers, &Sample { time, position, velocity, step: &self.bookkeeper.last }).map_err(RunError::Observer)
    }
}

/// The efforts that sampled motors hold from the start of a run on [N m or N], an entry a motor; `None` without such motors.
pub(crate) fn held_at(mechanism: &Mechanism, start: &State) -> Option<Vec<Option<f64>>> {
    let motors = &mechanism.nonsmooth.motors;
    let of = |motor: &Motor| {
        let at = motor.coordinate;
        let effort = || motor.effort(start.time, start.position[at.position], start.velocity[at.freedom]);
        (motor.period > 0.0).then(effort)
    };
    mechanism.nonsmooth.samples().then(|| motors.iter().map(of).collect())
}

#[cfg(test)]
mod tests;

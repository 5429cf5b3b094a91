//! A run that estimates its own error, and restarts with finer steps if the error becomes too large.
//!
//! ```text
//!     run, with a stop ε = E/100 at first ──step──▶ its next state x
//!     companion, from the same start      ───────▶ the same instant y        now and then: e = max |x − y|      distance.rs
//!     forecast of e at the end            ───────▶ go on, or restart with a finer stop                      forecast.rs
//! ```
//!
//! Trees carry their companion through their own steps, for a half of what these cost: it has the errors out of it that iterations leave
//! ([`crate::stepping::companion`]), and `y − x` is what they have grown to. Closed loops leave next to nothing to iterations, their errors are
//! those of the length of the steps; and events happen to two motions at two times. There the companion is a run of its own, with a stop that is
//! [`RATIO`] times coarser and steps of its own, and errors are proportional to the stop. What is further apart than a hundredth of the size of
//! the mechanism has parted and says nothing.
//!
//! At the finest stop nothing restarts: the run goes on, and tells until when the accuracy holds.

use crate::lobatto::numbers::lanes::Isa;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::distance::{distance, probes, size};
use crate::mechanism::motion::event::{Event, JointStatus};
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::accuracy::{Calibration, UnknownAccuracy};
use crate::simulation::beside::{Beside, RATIO};
use crate::simulation::event_order::first_difference;
use crate::simulation::forecast::{FINEST, Forecast, ROUNDED, Wanted};
use crate::simulation::run_integrator::RunIntegrator;
use crate::simulation::terms::Terms;
use crate::stepping::control::COARSEST_STOP;
use crate::stepping::integrator::MethodError;
use crate::stepping::stage_choice::StageChoice;

/// The wanted accuracy over the stop of a run that begins for the first time, of a smooth motion,
const OPTIMISTIC: f64 = 100.0;
/// and of one with events, which cost the more the later it restarts.
const CAREFUL: f64 = 1000.0;
/// Errors of runs are that of the companion over [`RATIO`], and larger by up to so much: a companion may be right by luck.
const LUCK: f64 = 3.0;
/// Roundings of two motions that round each in its own way.
const OWN_ROUNDINGS: f64 = 2.0;
/// Motions that are apart by this share of the mechanism's size have parted.
const PARTED: f64 = 1e-2;
/// Number of looks at a run that carries its companion, and at one with a run beside it.
const LOOKS: [f64; 2] = [128.0, 32.0];
/// However long a run is, the next look is after this part more of the time at the last.
const LATER: f64 = 1.25;
/// Steps between two looks, at least.
const STRIDE: usize = 4;
/// A run whose steps fail with a coarse stop restarts with one that is finer by this.
const AFTER_FAILURE: f64 = 1e-3;
/// In this first part of the run stability decides on the stages: what is stiff is so from the start, and to restart later is dear.
const EARLY: f64 = 1.0 / 16.0;

/// What the error of a run is told by.
enum By {
    /// A motion that is carried through the run's own steps.
    Carried,
    /// A coarser run.
    Beside(Box<Beside>),
    /// Nothing any more.
    Nothing,
}

/// The integrator of a run that knows how far it is off.
pub struct Assessed {
    terms: Terms,
    stop: f64,
    stages: StageChoice,
    run: RunIntegrator,
    by: By,
    forecast: Forecast,
    /// How often the run has begun.
    begun: usize,
    /// Whether it may restart.
    may_begin_again: bool,
    /// With what it is to restart.
    next: Option<(f64, StageChoice)>,
    /// Where the run begins, and the size of the mechanism there (m).
    origin: Option<State>,
    size: f64,
    steps: usize,
    /// Steps at the last look, and when the next is due (s).
    looked: usize,
    due: f64,
    /// The largest error so far at each look (s, m).
    trail: Vec<(f64, f64)>,
    parted: bool,
    /// What has happened, and from when on the run beside this one has met other events, if they have parted (s).
    events: Vec<Event>,
    differ: Option<f64>,
    /// Whether efforts from outside have acted, which no companion has felt.
    driven: bool,
}

impl Assessed {
    /// For a run under these terms.
    ///
    /// # Errors
    /// [`MethodError`] for steps that cannot be.
    pub(crate) fn new(mechanism: &Mechanism, terms: Terms) -> Result<Self, MethodError> {
        let smooth = mechanism.nonsmooth.is_empty();
        let part = if smooth { OPTIMISTIC } else { CAREFUL };
        let stop = (terms.tolerance / part).clamp(FINEST, COARSEST_STOP);
        let stages = StageChoice::of(mechanism, terms.tolerance);
        let run = terms.run(mechanism, stop, stages)?;
        let wanted = wanted(mechanism, &terms, stop);
        let mut assessed = Assessed {
            stop,
            stages,
            run,
            by: By::Nothing,
            forecast: Forecast::new(wanted),
            begun: 1,
            may_begin_again: true,
            next: None,
            origin: None,
            size: 0.0,
            steps: 0,
            looked: 0,
            due: 0.0,
            trail: Vec::new(),
            parted: false,
            events: Vec::new(),
            differ: None,
            driven: false,
            terms,
        };
        assessed.accompany(mechanism);
        Ok(assessed)
    }

    /// Goes on to the end, however far off it is.
    pub(crate) fn settle(&mut self) {
        self.may_begin_again = false;
    }

    /// Prepares the next beginning: finer if this part of the run is why there is one, and otherwise as before.
    ///
    /// # Errors
    /// [`MethodError`] for steps that cannot be.
    pub(crate) fn begin_again(&mut self, mechanism: &Mechanism) -> Result<(), MethodError> {
        self.begun += usize::from(self.next.is_some());
        (self.stop, self.stages) = self.next.take().unwrap_or((self.stop, self.stages));
        self.run = self.terms.run(mechanism, self.stop, self.stages)?;
        self.forecast = Forecast::new(wanted(mechanism, &self.terms, self.stop));
        (self.steps, self.looked, self.parted) = (0, 0, false);
        self.trail.clear();
        self.events.clear();
        self.differ = None;
        self.accompany(mechanism);
        Ok(())
    }

    /// Carries a companion where that tells the errors; one that runs by itself begins with the first step.
    fn accompany(&mut self, mechanism: &Mechanism) {
        self.by = if self.run.accompany(mechanism) { By::Carried } else { By::Nothing };
    }

    /// The coarser run beside this one, from a state on.
    fn beside(&self, mechanism: &Mechanism, state: &State) -> By {
        let beside = Beside::new(mechanism, &self.terms, self.stop, self.stages, state);
        beside.map_or(By::Nothing, |beside| By::Beside(Box::new(beside)))
    }

    /// Before the first step.
    fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        self.origin = Some(state.clone());
        self.size = size(mechanism, state);
        self.due = self.terms.start;
        if !matches!(self.by, By::Carried) {
            self.by = self.beside(mechanism, state);
        }
    }

    fn looks(&self) -> f64 {
        LOOKS[usize::from(!matches!(self.by, By::Carried))]
    }

    fn worst(&self) -> f64 {
        self.trail.last().map_or(0.0, |&(_, worst)| worst)
    }

    /// How far the run is off now (m); infinite if that cannot be told any more.
    fn error(&mut self, mechanism: &Mechanism, state: &State) -> f64 {
        let mut there = state.clone();
        if matches!(self.by, By::Carried) && !self.run.place_companion(&mut there) {
            self.by = self.origin.as_ref().map_or(By::Nothing, |origin| self.beside(mechanism, origin));
        }
        let share = match &mut self.by {
            By::Nothing => return f64::INFINITY,
            By::Carried if self.stop < ROUNDED => OWN_ROUNDINGS,
            By::Carried => 1.0,
            By::Beside(beside) => {
                // So coarse a run may fail where a finer one does not.
                if beside.advance(mechanism, state.time).is_err() {
                    return f64::INFINITY;
                }
                there.copy_from(&beside.state);
                if RATIO * self.stop < ROUNDED { OWN_ROUNDINGS } else { LUCK / RATIO }
            }
        };
        let apart = distance(&probes(mechanism, &there), &probes(mechanism, state));
        // What is not a number is as far apart as what has parted.
        if apart <= PARTED * self.size { apart * share } else { f64::INFINITY }
    }

    /// Looks how far the run is off, and decides whether it goes on.
    fn look(&mut self, mechanism: &Mechanism, state: &State) {
        if self.parted || matches!(self.by, By::Nothing) {
            return;
        }
        let error = self.error(mechanism, state).max(self.worst());
        self.trail.push((state.time, error));
        let Terms { start, end, .. } = self.terms;
        let later = (state.time - start) * LATER;
        (self.looked, self.due) = (self.steps, (state.time + (end - start) / self.looks()).min(start + later));
        if self.may_begin_again
            && self.stop > FINEST
            && let Some(predicted) = self.forecast.too_coarse(state.time, self.steps, error)
        {
            let stop = self.forecast.finer(predicted, self.begun > 1);
            self.next = Some((stop, StageChoice::of(mechanism, OPTIMISTIC * stop)));
        } else if error.is_infinite() {
            self.parted = true;
            self.differ = self.difference();
            self.by = By::Nothing;
            self.run.leave_companion();
        }
    }

    /// When the run and the one beside it meet other events for the first time (s).
    fn difference(&self) -> Option<f64> {
        let By::Beside(beside) = &self.by else { return None };
        first_difference(&self.events, &beside.events)
    }

    /// What the run has shown of its accuracy up to this state, where it ends.
    ///
    /// # Errors
    /// [`UnknownAccuracy`] where efforts from outside have acted, and before the first step.
    pub(crate) fn accuracy(&mut self, mechanism: &Mechanism, state: &State) -> Result<Calibration, UnknownAccuracy> {
        if self.driven {
            return Err(UnknownAccuracy::Driven);
        }
        if self.steps == 0 {
            return Err(UnknownAccuracy::NotYet);
        }
        if self.trail.last().is_none_or(|&(time, _)| time < state.time) {
            self.settle();
            self.look(mechanism, state);
        }
        let held = self.trail.iter().take_while(|&&(_, error)| error <= self.terms.tolerance).last();
        let holds_until = held.map_or(self.terms.start, |&(time, _)| time);
        // Where other events change next to nothing they are none of the user's business.
        let differ = if holds_until < state.time { self.differ.or_else(|| self.difference()) } else { None };
        Ok(Calibration {
            stop: self.stop,
            stages: self.stages,
            // What has parted ends as far apart as the mechanism is large. No position is known better than it is rounded.
            estimate: if self.parted { self.size } else { self.worst().max(f64::EPSILON * self.size) },
            holds_until: differ.map_or(holds_until, |differ| holds_until.min(differ)),
            parted: self.parted,
            events_differ: differ,
            pilots: 0,
            begun: self.begun,
        })
    }
}

fn wanted(mechanism: &Mechanism, terms: &Terms, stop: f64) -> Wanted {
    let grows = mechanism.velocity_count > 1;
    Wanted { accuracy: terms.tolerance, stop, start: terms.start, end: terms.end, grows }
}

impl Integrator for Assessed {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        if self.steps == 0 {
            self.begin(mechanism, state);
        }
        if !inputs.is_none() && !self.driven {
            self.driven = true;
            self.by = By::Nothing;
            self.run.leave_companion();
        }
        let outcome = match self.run.step(mechanism, inputs, state, until) {
            // What fails with a coarse stop may do with a finer one.
            Err(_) if self.may_begin_again && self.begun == 1 => {
                self.next = Some(((self.stop * AFTER_FAILURE).max(FINEST), self.stages));
                return Ok(StepOutcome::default());
            }
            outcome => outcome?,
        };
        self.steps += 1;
        let Terms { start, end, .. } = self.terms;
        let few = || self.stages.count(Isa::detect()) < StageChoice::Filling.count(Isa::detect());
        let early = state.time - start <= EARLY * (end - start);
        if self.may_begin_again && early && self.run.was_held_by_stability() && few() {
            self.next = Some((self.stop, StageChoice::Filling));
        } else if state.time >= end || (state.time >= self.due && self.steps >= self.looked + STRIDE) {
            self.look(mechanism, state);
        }
        Ok(outcome)
    }

    fn begins_again(&self) -> bool {
        self.next.is_some()
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.run.dense(mechanism, time, position, velocity);
    }

    fn description(&self) -> MethodDescription {
        self.run.description()
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        let before = events.len();
        self.run.take_events(events);
        self.events.extend_from_slice(&events[before..]);
    }

    fn joint_status(&self, mechanism: &Mechanism, state: &State, body: usize) -> JointStatus {
        self.run.joint_status(mechanism, state, body)
    }

    fn contacts(&self, mechanism: &Mechanism, state: &State, out: &mut Vec<ContactPoint>) {
        self.run.contacts(mechanism, state, out);
    }
}

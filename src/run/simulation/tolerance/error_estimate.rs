//! The estimate of a run's error while it goes on, and the restart with finer steps if the error becomes too large.
//!
//! ```text
//!     run, with a stop ε = E/100 at first ──step──▶ its next state x
//!     companion, from the same start      ───────▶ the same instant y        now and then: e = max |x − y|      distance.rs
//!     forecast of e at the end            ───────▶ go on, or restart with a finer stop                      forecast.rs
//! ```
//!
//! A tree integrates its companion with its own steps, for half of their cost. The companion has the errors that iterations leave removed
//! ([`crate::stepping::length::companion`]), and `y − x` is the accumulated error. In closed loops the errors of iterations are negligible beside the
//! errors of the step length; and with events two motions meet them at two times. There the companion is a separate run with its own steps and a stop
//! that is `beside::RATIO` times coarser; errors are proportional to the stop. Its steps of first order are twice as long, so that their part of the distance
//! is the error itself ([`Beside::share_of_first_order`]). A distance above a hundredth of the mechanism's size is the error as a whole: one impact that
//! only one of the motions meets may make it. Motions further apart than a tenth of the size have parted and give no estimate.
//!
//! A companion may be far off where the run is not. What the iterations leave of a carried one is a part of the distance of the two, so that a distance
//! that should grow in proportion to time grows by some percent a step. A coarser run may miss an event, or step over it. So another one is asked, once,
//! before a run is said to be off: a separate run instead of a carried companion, a finer one instead of a coarser one ([`Beside::finer`]). It stays
//! beside the run where it is nearer.
//!
//! At the finest stop no run restarts: it continues, and reports the time until which the accuracy holds. So does a run that met other events than
//! its companion, where finer steps would carry it hardly further ([`crate::simulation::tolerance::horizon`]). A run that is not far from the accuracy at
//! its end, because of steps over events, restarts once with shorter and fewer of these ([`opinions`]).

use crate::events::crowded::CrowdsSoFar;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::distance::{distance, probes, probes_of_bodies, size};
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::accuracy::{Accuracy, UnknownAccuracy, may_be_chaotic};
use crate::simulation::tolerance::accuracy_so_far::AccuracySoFar;
use crate::simulation::tolerance::beside::{Behind, Beside, OWN_ROUNDINGS};
use crate::simulation::tolerance::forecast::{FINEST, Forecast, ROUNDED, Wanted};
use crate::simulation::tolerance::given_forces::GivenForces;
use crate::simulation::tolerance::handed::{Companion, Fineness};
use crate::simulation::tolerance::horizon::Horizon;
use crate::simulation::tolerance::terms::Terms;
use crate::stepping::integrator::MethodError;
use crate::stepping::length::stage_choice::StageChoice;

/// The accuracy over the stop, for which stages are chosen when the run restarts.
const OPTIMISTIC: f64 = 100.0;
/// Motions have parted if their distance exceeds this share of the mechanism's size.
const PARTED: f64 = 0.1;
/// Distances above this share of the size are no part of a companion's error any more: they are the error.
const LARGE: f64 = 1e-2;
/// Such a distance counts at most this often: both motions may be as far off.
const BOTH: f64 = 2.0;
/// Runs that meet other events part if they are this share of the size apart: steps over events are no worse. Less is an error of rebounds that were left out.
const FAR: f64 = 1e-4;
/// Number of estimates in a run with a carried companion, and in one with a separate companion.
const LOOKS: [f64; 2] = [128.0, 32.0];
/// However long a run is, the next estimate is made when its time has grown by this factor at most.
const LATER: f64 = 1.25;
/// Least number of steps between two estimates.
const STRIDE: usize = 4;
/// A run whose steps fail with a coarse stop restarts with a stop smaller by this factor.
const AFTER_FAILURE: f64 = 1e-3;
/// In this first part of the run stability may change the stages: stiffness shows from the start, and a later restart is expensive.
const EARLY: f64 = 1.0 / 16.0;

mod handing;
mod opinions;

/// How the error of a run is estimated.
enum By {
    /// The estimate comes from a companion that is integrated with the run's own steps.
    Carried,
    /// The estimate comes from a separate run, a coarser or a finer one.
    Beside(Box<Beside>),
    /// Not any more.
    Nothing,
}

/// The estimate of the error of a run, whose integrator each of its functions is handed.
pub struct ErrorEstimate<'a> {
    terms: Terms<'a>,
    stop: f64,
    stages: StageChoice,
    by: By,
    forecast: Forecast,
    /// How many times the run was begun.
    begun: usize,
    /// Whether it may restart.
    may_begin_again: bool,
    /// Whether it may restart because of steps over events.
    may_refine: bool,
    /// The stop and stages of the restart.
    next: Option<(f64, StageChoice)>,
    /// Where motions beside the run begin, and the size of the mechanism there (m).
    origin: Option<State>,
    size: f64,
    steps: usize,
    /// Where the steps towards one instant began, to which the run may go back, and that instant (s).
    began: f64,
    towards: f64,
    /// Number of steps at the last estimate, and the time of the next one (s).
    looked: usize,
    due: f64,
    /// The largest error of ends of steps so far (m).
    largest: f64,
    /// The last estimate.
    so_far: Option<AccuracySoFar>,
    parted: bool,
    /// Whether the last opinion was asked for.
    asked: bool,
    /// The events so far, and the time from which the separate run has met different ones (s), if any.
    events: Vec<Event>,
    differ: Option<f64>,
    /// From when on no steps carry it on.
    horizon: Horizon,
    /// Whether external efforts have acted, which the companion does not have.
    driven: bool,
    /// The error of forces given in time.
    given: GivenForces,
    /// The motion beside the run where it begins, if it is another one; its distance from there is at least this error (m), and the error of the run this
    /// part of the distance; and the error there that such a motion does not show (m).
    companion: Option<Companion>,
    shown: f64,
    least_share: f64,
    before: f64,
    /// The steps of the runs that it goes on from, and what the motions beside them have seen of crowds.
    earlier: usize,
    crowds: Option<CrowdsSoFar>,
}

impl<'a> ErrorEstimate<'a> {
    /// The estimate of a run with these settings, and the integrator of that.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub fn new(mechanism: &Mechanism, terms: Terms<'a>) -> Result<(Self, RunIntegrator), MethodError> {
        let fineness = Fineness::first(mechanism, &terms);
        Self::as_fine_as(mechanism, terms, fineness)
    }

    /// The same, as fine as that.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub(crate) fn as_fine_as(
        mechanism: &Mechanism,
        mut terms: Terms<'a>,
        fineness: Fineness,
    ) -> Result<(Self, RunIntegrator), MethodError> {
        let Fineness { stop, stages, begun, may_begin_again, may_refine, over_events, horizon } = fineness;
        terms.over_events = over_events;
        let mut run = terms.run(mechanism, stop, stages)?;
        let wanted = wanted(mechanism, &terms, stop);
        let mut estimate = ErrorEstimate {
            stop,
            stages,
            by: By::Nothing,
            forecast: Forecast::new(wanted),
            begun,
            may_begin_again,
            may_refine,
            next: None,
            origin: None,
            size: 0.0,
            steps: 0,
            began: f64::NEG_INFINITY,
            towards: f64::NEG_INFINITY,
            looked: 0,
            due: 0.0,
            largest: 0.0,
            so_far: None,
            parted: false,
            asked: false,
            events: Vec::new(),
            differ: None,
            horizon,
            driven: false,
            given: GivenForces::default(),
            companion: None,
            shown: 0.0,
            least_share: 0.0,
            before: 0.0,
            earlier: 0,
            crowds: None,
            terms,
        };
        estimate.accompany(mechanism, &mut run);
        Ok((estimate, run))
    }

    /// Efforts or targets from outside act from now on, which the motion beside the run does not have.
    pub(crate) fn drive(&mut self, run: &mut RunIntegrator) {
        if !self.driven {
            self.driven = true;
            self.by = By::Nothing;
            run.leave_companion();
        }
    }

    /// Forbids restarts, whatever the error.
    pub(crate) fn settle(&mut self) {
        (self.may_begin_again, self.may_refine) = (false, false);
    }

    /// Prepares the next beginning, and returns its integrator: finer if this island caused the restart, and otherwise as before.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub fn begin_again(&mut self, mechanism: &Mechanism, before: &RunIntegrator) -> Result<RunIntegrator, MethodError> {
        let fineness = self.next_fineness(before);
        let (again, run) = Self::as_fine_as(mechanism, self.terms.clone(), fineness)?;
        *self = ErrorEstimate { driven: self.driven, ..again };
        Ok(run)
    }

    /// Starts a carried companion if it can estimate the error; a separate one starts with the first step.
    fn accompany(&mut self, mechanism: &Mechanism, run: &mut RunIntegrator) {
        let carried = self.terms.estimate && run.accompany(mechanism);
        self.by = if carried { By::Carried } else { By::Nothing };
    }

    /// A separate run from a state on, a coarser or a finer one.
    fn beside(&self, mechanism: &Mechanism, state: &State, is_finer: bool) -> By {
        let ask = if is_finer { Beside::finer } else { Beside::coarser };
        let beside = ask(mechanism, &self.terms, self.stop, self.stages, state);
        beside.map_or(By::Nothing, |beside| By::Beside(Box::new(beside)))
    }

    /// Prepares the estimate before the first step.
    fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        let companion = self.companion.take();
        let is_finer = companion.as_ref().is_some_and(|companion| companion.is_finer);
        let origin = companion.map_or_else(|| state.clone(), |companion| companion.state);
        self.size = size(mechanism, state);
        self.due = self.terms.start;
        if self.terms.estimate && !matches!(self.by, By::Carried) && !self.parted && !self.driven {
            self.by = self.beside(mechanism, &origin, is_finer);
            self.asked = is_finer;
            if let By::Beside(beside) = &mut self.by {
                beside.run.go_on_from(self.crowds);
            }
        }
        self.origin = Some(origin);
    }

    fn looks(&self) -> f64 {
        LOOKS[usize::from(!matches!(self.by, By::Carried))]
    }

    /// The last estimate, if there was one.
    pub(crate) fn so_far(&self) -> Option<AccuracySoFar> {
        self.so_far
    }

    /// The present error (m), or `None` if the run was interrupted before it was known; infinite if it cannot be estimated any more.
    fn error(&mut self, mechanism: &Mechanism, state: &State, run: &RunIntegrator) -> Option<f64> {
        let carried = match self.by {
            By::Carried => run.companion_probes(mechanism, state),
            _ => None,
        };
        if matches!(self.by, By::Carried) && carried.is_none() {
            self.by = self.origin.as_ref().map_or(By::Nothing, |origin| self.beside(mechanism, origin, false));
        }
        let (there, share) = match &mut self.by {
            By::Nothing => return Some(f64::INFINITY),
            By::Carried => (carried.unwrap_or_default(), if self.stop < ROUNDED { OWN_ROUNDINGS } else { 1.0 }),
            By::Beside(beside) => {
                match beside.advance_by_way_of(mechanism, &self.terms, [self.began, state.time]) {
                    Ok(()) => {}
                    Err(Behind::Failed) => return Some(f64::INFINITY),
                    Err(Behind::Interrupted) => return None,
                }
                let share = beside.share(run, self.stop, self.stages, self.steps).max(self.least_share);
                (probes(mechanism, &beside.state), share)
            }
        };
        let placed = run.bodies().map(|bodies| probes_of_bodies(mechanism, bodies));
        let apart = distance(&there, &placed.unwrap_or_else(|| probes(mechanism, state)));
        self.horizon.see(state.time, apart.min(LARGE * self.size));
        let share = if apart <= LARGE * self.size { share } else { share.clamp(1.0, BOTH) };
        // NaN counts as parted.
        Some(if apart <= PARTED * self.size { apart * share } else { f64::INFINITY })
    }

    /// Whether runs with this error (m) part.
    fn is_far(&self, error: f64) -> bool {
        error > (FAR * self.size).max(self.terms.tolerance)
    }

    /// Estimates the error, and decides whether the run continues.
    fn look(&mut self, mechanism: &Mechanism, state: &State, run: &mut RunIntegrator) {
        if self.parted || matches!(self.by, By::Nothing) {
            return;
        }
        let Some(error) = self.error(mechanism, state, run) else { return };
        let mut error = error.max(self.largest);
        // Samples inside steps that are too long for a damper may be off where the ends are right.
        let ringing = run.figures().ringing;
        let Terms { start, end, tolerance: wanted, .. } = self.terms;
        let restarts = self.finer_stop(state, error, ringing, run);
        // A separate run, and then a finer one.
        for _ in 0..2 {
            if restarts.is_none() && error + self.doubt(state.time, run) > wanted {
                error = self.second_opinion(mechanism, state, error, run);
            }
        }
        // The ends of accumulating impacts are errors of the run and of its companion alike, and so are those of forces given in time.
        let of_impacts = run.error_of_impacts(state.time) + self.doubt(state.time, run);
        let estimate = error.max(ringing) + of_impacts + self.given.error(state.time) + self.before;
        let held = self.so_far.map_or(start, |so_far| so_far.holds_until);
        let holds_until = if estimate <= wanted { state.time } else { held };
        self.so_far = Some(AccuracySoFar { time: state.time, wanted, estimate, holds_until });
        self.largest = error;
        let later = (state.time - start) * LATER;
        (self.looked, self.due) = (self.steps, (state.time + (end - start) / self.looks()).min(start + later));
        if let Some(stop) = restarts {
            self.next = Some((stop, StageChoice::of(mechanism, OPTIMISTIC * stop)));
        } else if let Some(part) = self.finer_over_events(mechanism, state, estimate, run) {
            self.terms.over_events = part;
            self.next = Some(((part * self.stop).max(FINEST), self.stages));
        } else if error.is_infinite() {
            self.parted = true;
            self.differ = self.difference(run);
            self.by = By::Nothing;
            run.leave_companion();
            if run.smeared()[0] > 0.0 {
                run.pass_horizon();
            }
        }
        let finer = self.may_begin_again && self.stop > FINEST;
        if self.next.is_none()
            && self.is_far(estimate)
            && !finer
            && self.differ.or_else(|| self.difference(run)).is_some()
        {
            run.pass_horizon();
            if let By::Beside(beside) = &mut self.by {
                beside.run.pass_horizon();
            }
        }
    }

    /// The estimated accuracy of the run up to this state, its end.
    ///
    /// # Errors
    /// [`UnknownAccuracy`] if external efforts have acted, and before the first step.
    pub(crate) fn accuracy(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        run: &mut RunIntegrator,
    ) -> Result<Accuracy, UnknownAccuracy> {
        if !self.terms.estimate {
            return Err(UnknownAccuracy::NotEstimated);
        }
        if self.driven {
            return Err(UnknownAccuracy::Driven);
        }
        if self.steps == 0 && self.so_far.is_none() {
            return Err(UnknownAccuracy::NotYet);
        }
        if self.so_far.is_none_or(|so_far| so_far.time < state.time) {
            self.settle();
            self.look(mechanism, state, run);
        }
        // If the separate run was interrupted before this time, the last estimate is kept.
        let Some(AccuracySoFar { time, holds_until, .. }) = self.so_far else { return Err(UnknownAccuracy::NotYet) };
        // Different events with a small effect are not reported, as where rebounds are left out: no roundings grow in them.
        let is_far = self.parted || self.so_far.is_some_and(|so_far| self.is_far(so_far.estimate));
        let differ = if holds_until < time && is_far { self.differ.or_else(|| self.difference(run)) } else { None };
        Ok(Accuracy {
            stop: self.stop,
            stages: self.stages,
            // Runs that have parted may end at any distance up to the size of the mechanism. No position is more accurate than its rounding.
            estimate: if self.parted {
                self.size
            } else {
                self.so_far.map_or(0.0, |so_far| so_far.estimate).max(f64::EPSILON * self.size)
            },
            between_steps: run.figures().between,
            holds_until: differ.map_or(holds_until, |differ| holds_until.min(differ)),
            told_until: if self.parted { state.time } else { time },
            parted: self.parted,
            amplifies: may_be_chaotic(mechanism) && (is_far || self.stop <= FINEST),
            events_differ: differ,
            begun: self.begun,
        })
    }

    /// Whether the steps so far were too coarse: the run restarts.
    pub(crate) fn begins_again(&self) -> bool {
        self.next.is_some()
    }

    /// Sees events of the run.
    pub(crate) fn see_events(&mut self, events: &[Event]) {
        self.events.extend_from_slice(events);
    }

    /// Makes a step of the run, and estimates the error now and then.
    ///
    /// # Errors
    /// [`StepError`] of a step that cannot be made, where finer steps would not help.
    pub(crate) fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
        run: &mut RunIntegrator,
    ) -> Result<StepOutcome, StepError> {
        if self.steps == 0 {
            self.begin(mechanism, state);
        }
        if !inputs.is_none() {
            self.drive(run);
        }
        let from = state.time;
        if until != self.towards {
            (self.began, self.towards) = (from, until);
        }
        let outcome = match run.step(mechanism, inputs, state, until) {
            // Steps that fail with a coarse stop may succeed with a finer one.
            Err(_) if self.may_begin_again && self.begun == 1 => {
                self.next = Some(((self.stop * AFTER_FAILURE).max(FINEST), self.stages));
                return Ok(StepOutcome::default());
            }
            outcome => outcome?,
        };
        self.steps += 1;
        if self.terms.estimate {
            self.given.see(mechanism, self.stages.count(), [from, state.time]);
        }
        let Terms { start, end, .. } = self.terms;
        let early = state.time - start <= EARLY * (end - start);
        let is_early = self.may_begin_again && early && self.stages == StageChoice::Few;
        if is_early && run.figures().held_by_stability {
            self.next = Some((self.stop, StageChoice::Many));
        } else if state.time >= end || (state.time >= self.due && self.steps >= self.looked + STRIDE) {
            self.look(mechanism, state, run);
        }
        Ok(outcome)
    }
}

fn wanted(mechanism: &Mechanism, terms: &Terms, stop: f64) -> Wanted {
    let grows = mechanism.velocity_count > 1;
    let events = !mechanism.nonsmooth.is_empty();
    Wanted { accuracy: terms.tolerance, stop, start: terms.start, end: terms.end, grows, events }
}

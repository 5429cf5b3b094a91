//! One step in a mode: to an event, to an instant at which an effort changes its law, or as far as the step goes.
//!
//! ```text
//!     step h of what moves ─▶ φ on its dense output ─▶ none: accepted
//!                                                   └▶ a bracket: located (location.rs)
//! ```

use crate::events::careful::MOST;
use crate::events::effects::resting;
use crate::events::finding::detection::Bracket;
use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::drives::displacement;
use crate::events::modes::mode::{Closed, JointMode};
use crate::events::modes::piece::Piece;
use crate::events::next_step::{Ending, NextStep};
use crate::events::parts::spending::Ended;
use crate::events::price::{ITERATION, LOOK, decision};
use crate::events::quiet::QUIET;
use crate::events::sliding::{JAM, Stopping};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::contact::TouchJoint;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::energy::energy;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Rejected, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{belt, touch_motion};

/// A step with a defect is made again with this part of its length.
pub(super) const SHORTER: f64 = 1.0 / 16.0;
/// A step in which a slip passes near its stop is shortened by this factor.
const HALF: f64 = 0.5;

/// One step that is being made: kept while it is made again and again, thrown away with it.
struct Attempt {
    /// Where it begins, and how far it is to go (s).
    since: f64,
    until: f64,
    /// Whether some functions are not looked at.
    passing: bool,
    /// Whether a given instant bounds it.
    given: bool,
    /// An event that is nearer to the start than this is there (s).
    shortest: f64,
    /// Unknowns of the stages, for the count of the work.
    unknowns: usize,
    /// A slip that stops sooner than steps are long, by its number among the watched functions.
    slow: Option<usize>,
    /// The slip that ends the step where it begins: one that falls straight to its stop, or that no step can follow.
    stopped: Option<usize>,
}

impl Eventful {
    /// Makes one step towards `until`, which no effort's law changes before. A step that ends well but has a defect is begun anew, shorter.
    pub(super) fn advance(
        &mut self,
        inputs: Inputs,
        state: &mut State,
        until: f64,
        next: NextStep,
    ) -> Result<StepOutcome, StepError> {
        let since = state.time;
        let mut until = match next {
            NextStep::Passing { at_most } => until.min(since + at_most),
            NextStep::Watched | NextStep::FirstOrder => until,
        };
        loop {
            let mut attempt = self.begin_attempt(inputs, state, until, matches!(next, NextStep::Passing { .. }));
            let mut outcome = StepOutcome::default();
            let ending = self.make(inputs, &mut attempt, &mut outcome);
            self.take_failed_cost();
            let ending = match ending {
                Ok(ending) => ending,
                Err(error) => {
                    self.tally.abandoned.add(&outcome.cost);
                    return Err(error);
                }
            };
            self.hand_out(state, &ending, &mut outcome);
            let Some(why) = self.defect(inputs, state, &ending, &outcome) else {
                self.conclude(inputs, state, &attempt, ending, &mut outcome);
                return Ok(outcome);
            };
            self.tally.abandoned.add(&outcome.cost);
            self.tally.abandoned.reject(why);
            if outcome.step <= JAM {
                return Err(StepError::NotAccurate { time: since, step: outcome.step });
            }
            self.workspaces.active_mut().go_back(since, &self.model.recipe);
            state.copy_from(&self.trial.origin);
            until = since + if why == Rejected::SlipTurned { HALF } else { SHORTER } * outcome.step;
        }
    }

    /// Begins a step: its efforts, the directions of slips, and how far it may go.
    fn begin_attempt(&mut self, inputs: Inputs, state: &State, until: f64, passing: bool) -> Attempt {
        let since = state.time;
        self.trial.origin.copy_from(state);
        self.workspaces.last = self.workspaces.current;
        self.trial.forget_looks();
        inputs.write_constant(&mut self.trial.efforts);
        self.mode.add_constant_efforts(&self.model.elements, &mut self.trial.efforts);
        self.trial.holding.foreseen.begin(&self.trial.efforts);
        self.note_slips(state);
        if !self.model.touching.pairs.is_empty() {
            match &mut self.previous.stepped_in {
                Some(known) => known.copy_from(&self.mode),
                none => *none = Some(self.mode.clone()),
            }
        }
        let shortest = self.shortest_passing(since);
        let Stopping { until: soon, slow, straight } = self.soon_after_stop(inputs, since, state);
        let stopped = slow.filter(|_| straight && !passing);
        let soon = self.before_passes(since, soon.min(until));
        let given = self.progress.bounded && !passing && until <= soon;
        let contacts = self.mode.contacts.len();
        let piece = self.workspaces.active_mut();
        let unknowns = piece.moving.mechanism.velocity_count + 3 * contacts;
        let rests = piece.steps.is_none();
        if let Some(steps) = &mut piece.steps {
            steps.expect_instant(given);
        }
        piece.begin(&self.model.whole, inputs, &self.trial.efforts, &self.trial.origin);
        let until = if rests { self.model.next_extreme(since, soon) } else { soon };
        Attempt { since, until, passing, given, shortest, unknowns, slow, stopped }
    }

    /// Makes the step, ends it at its first event, and says how it ended.
    fn make(&mut self, inputs: Inputs, attempt: &mut Attempt, outcome: &mut StepOutcome) -> Result<Ending, StepError> {
        let since = attempt.since;
        // A step to a stop that is nearer than steps are long can be solved seldom, and would end here.
        if attempt.stopped.is_none() {
            match self.step_towards(inputs, since, attempt.until) {
                Ok(made) => *outcome = made,
                // One that cannot be solved has a slip that turns before it stops, or begins again.
                Err(StepError::NotConverged { .. } | StepError::NotAccurate { .. }) if attempt.slow.is_some() => {
                    self.workspaces.active_mut().go_back(since, &self.model.recipe);
                    attempt.stopped = attempt.slow;
                }
                Err(error) => return Err(error),
            }
        }
        let bracket = match attempt.stopped {
            Some(slip) => Some(Bracket::at_start(slip, since)),
            None => self.first_bracket(inputs, attempt.since, attempt.shortest, outcome)?,
        };
        let mut triggers = match bracket {
            Some(bracket) => self.end_at_first(inputs, bracket, attempt.shortest, outcome)?,
            None => Vec::new(),
        };
        Ok(if self.workspaces.active().small.time > since {
            if triggers.is_empty() { Ending::Full } else { Ending::AtEvent(triggers) }
        } else if !attempt.passing && self.go_ballistically(inputs, attempt.shortest, &mut triggers) {
            Ending::Ballistic(triggers)
        } else {
            Ending::AtStart(triggers)
        })
    }

    /// Writes where the step ended, with its length and the energy that went in and out.
    fn hand_out(&mut self, state: &mut State, ending: &Ending, outcome: &mut StepOutcome) {
        if ending.is_at_start() {
            state.copy_from(&self.trial.origin);
        } else {
            let piece = self.workspaces.active_mut();
            piece.moving.spread(&self.model.whole, &piece.small, state);
        }
        outcome.step = state.time - self.trial.origin.time;
        let of_scheme = ending.is_of_scheme();
        let kernel = if of_scheme { outcome.exchange } else { Exchange::default() };
        outcome.exchange = self.exchanged(state, kernel, !of_scheme);
        if matches!(ending, Ending::Ballistic(_)) {
            let [before, after] =
                [&self.trial.origin, &*state].map(|state| resting::energy(&self.model.whole, state).total());
            let taken = if self.slides() { &mut outcome.exchange.friction } else { &mut outcome.exchange.dissipated };
            *taken += before - after;
        }
    }

    /// Why the step is to be made anew, although it could be made to its end.
    fn defect(&mut self, inputs: Inputs, state: &State, ending: &Ending, outcome: &StepOutcome) -> Option<Rejected> {
        let is_moment = ending.is_moment(outcome.step) && self.closes_alone(ending.triggers(), state);
        let overlaps = (outcome.step > JAM || is_moment) && self.overlaps(state);
        if overlaps {
            Some(Rejected::Overlap)
        } else if !ending.is_at_start()
            && !is_moment
            && (ending.is_of_scheme() && self.trial.looking.room.unclear || self.has_hole(self.trial.origin.time))
        {
            Some(Rejected::Unseen)
        } else if ending.is_of_scheme() && !ending.is_at_start() && self.passes_a_stop(state) {
            Some(Rejected::SlipTurned)
        } else if ending.is_of_scheme() && outcome.step > JAM && self.ends_in_transient(ending.triggers()) {
            Some(Rejected::NotSmooth)
        } else {
            self.is_off_balance(inputs, state, ending, &outcome.exchange).then_some(Rejected::OffBalance)
        }
    }

    /// Whether an impact, or a joint that stops or lets go, ends the step while rates may have a part of a transient that hard dampers have stopped. The
    /// impact would carry it on into the motion, and rates and efforts that have it are zero at another instant.
    fn ends_in_transient(&self, triggers: &[Watched]) -> bool {
        let heeds = |trigger: &Watched| {
            matches!(trigger, Watched::Gap(..) | Watched::Approach(..) | Watched::Slide(..) | Watched::Bears(..))
        };
        triggers.iter().any(heeds)
            && self.workspaces.active().steps.as_ref().is_some_and(|steps| steps.leaves_transient())
    }

    /// Keeps the step: takes its findings, carries out the events at its end, enters the mode that follows, and sees whether all has come to rest.
    fn conclude(
        &mut self,
        inputs: Inputs,
        state: &mut State,
        attempt: &Attempt,
        ending: Ending,
        outcome: &mut StepOutcome,
    ) {
        let (since, passing) = (attempt.since, attempt.passing);
        let at_start = ending.is_at_start();
        let (known, fast) = (self.tally.events.len(), self.slips_fast());
        self.trace_step(state, &ending);
        if !at_start && !self.model.touching.pairs.is_empty() {
            self.bound_overlap(since);
            if !ending.is_moment(outcome.step) {
                self.check_covers(since);
            }
        }
        self.remember(state);
        self.trial.wear_off();
        let changed = self.meet_instants(inputs, state);
        let mut triggers = ending.triggers().to_vec();
        if !triggers.is_empty() || changed || passing {
            self.progress.repeats.see(&self.mode, state, at_start, passing);
            self.progress.repeats.note(&triggers, at_start, &self.trial.watched);
            if triggers.is_empty() && passing {
                triggers = self.overlooked();
            }
            let mode = self.mode.clone();
            outcome.exchange += self.pass(inputs, state, &triggers, attempt.stopped.is_some());
            if at_start && let Some(left) = self.progress.repeats.close_cycle(&self.mode, state, self.memory.fastest) {
                self.progress.spending.repeat(left);
            }
            // A slip that was stopped has changed, even if it begins again.
            self.progress.repeats.take_change(at_start && attempt.stopped.is_none() && mode.is_like(&self.mode));
        }
        if !(passing || at_start) {
            self.progress.repeats.advance();
        }
        let lasts = inputs.feedback.is_none() && !self.model.whole.changes();
        let quiet = triggers.is_empty() && !changed && lasts && self.is_quiet(state);
        self.progress.quiet = if quiet { self.progress.quiet + 1 } else { 0 };
        if matches!(ending, Ending::Ballistic(_)) {
            // No step was made that has an inside.
            self.progress.stepped_over = Some(state.clone());
        }
        if self.progress.quiet >= QUIET {
            self.progress.asleep = true;
            state.velocity.fill(0.0);
            self.enter(state);
        }
        self.tally.steps += 1;
        self.tally.stepped += outcome.step;
        let cheap =
            self.workspaces.pieces[self.workspaces.last].steps.as_ref().is_none_or(|steps| steps.is_cheap_span());
        let ended = match (triggers.is_empty(), attempt.given && !cheap && self.counts_instants()) {
            (false, _) => Ended::AtEvent,
            (true, true) => Ended::AtInstant,
            (true, false) if outcome.step < MOST && self.slides() => Ended::AtSlip,
            (true, false) => Ended::Smoothly,
        };
        let iterations = outcome.cost.iterations + self.tally.abandoned.iterations;
        self.note_cost(since, iterations, attempt.unknowns, ended);
        let impact = self.tally.events.iter().skip(known).any(|event| event.impulse.is_some());
        self.progress.spending.see(since, impact, fast);
    }

    /// Remembers the largest rates, speeds and kinetic energy at the end of a step.
    fn remember(&mut self, state: &State) {
        for (memory, joint) in self.memory.joints.iter_mut().zip(&self.model.elements.joints) {
            memory.fastest = memory.fastest.max(joint.rate(state).abs());
        }
        if !self.model.touching.pairs.is_empty() {
            self.trial.placed.place(&self.model.whole, state, &mut self.trial.bodies);
            let speeds = self.trial.bodies.iter().map(|body| body.velocity.norm());
            let rubs = |closed: &&Closed| self.model.touching.pairs[closed.contact.pair].friction > 0.0;
            let touching = self.mode.contacts.iter().filter(rubs);
            let touching = touching.map(|closed| speed_of_terms(&closed.contact.joint, &self.trial.bodies));
            self.memory.fastest = speeds.chain(touching).fold(self.memory.fastest, f64::max);
            self.memory.kinetic = self.memory.kinetic.max(energy(&self.model.whole, &self.trial.bodies).kinetic);
        }
    }

    /// Counts the cost of steps of the piece in use that failed.
    pub(super) fn take_failed_cost(&mut self) {
        if let Some(steps) = &mut self.workspaces.active_mut().steps {
            self.tally.abandoned.add(&steps.take_abandoned());
        }
    }

    /// Counts the cost of a step from a time (s) on; given steps may be many between events.
    fn note_cost(&mut self, since: f64, iterations: usize, unknowns: usize, ended: Ended) {
        let looks = std::mem::take(&mut self.trial.looks) as f64 * LOOK;
        if self.model.recipe.tolerance().is_some() || ended == Ended::AtEvent {
            let decided = if ended == Ended::AtEvent { decision(self.mode.contacts.len()) } else { 0.0 };
            let cost = ITERATION * iterations as f64 * (unknowns as f64).powi(2) + looks + decided;
            self.progress.spending.spend(since, cost, ended);
        }
    }

    /// The pairs that overlap at the end of a step that did not look at them.
    fn overlooked(&self) -> Vec<Watched> {
        let overlaps = |watched: &&Watched| match **watched {
            Watched::Approach(pair) => self.model.touching.overlaps(pair, &self.trial.bodies, 0.0),
            _ => false,
        };
        self.progress.repeats.ignored.iter().filter(overlaps).copied().collect()
    }

    /// The energy that went in and out in the step (J): the sums of the scheme for the reduced mechanism, told apart.
    fn exchanged(&mut self, end: &State, kernel: Exchange, nothing: bool) -> Exchange {
        if nothing {
            return Exchange::default();
        }
        let mut friction = 0.0;
        for (joint, mode) in self.model.elements.joints.iter().zip(&self.mode.joints) {
            if let JointMode::Free { sliding } = mode {
                let moved = displacement(&self.trial.origin, end, joint.coordinate.position);
                friction += f64::from(*sliding) * moved * joint.friction;
            }
        }
        let Piece { drives, steps, small, small_start, .. } = self.workspaces.active_mut();
        let (given, taken) =
            steps.as_ref().map_or((0.0, 0.0), |own| drives.exchanged(own.as_ref(), small_start, small));
        // Without dampers it is all of the motors, and no rounding of a difference.
        let forces = &self.model.whole.forces;
        let between_points = forces.point_springs.iter().any(|spring| spring.damping > 0.0);
        let damped = between_points || !forces.joint_dampers.is_empty() || !forces.drags.is_empty();
        let taken = if damped { taken } else { kernel.dissipated };
        Exchange {
            dissipated: kernel.dissipated - taken,
            work: kernel.work + friction + given - taken,
            friction: friction + kernel.friction,
            impacts: 0.0,
        }
    }
}

/// The largest of the terms whose difference is the slip of a contact [m/s]: a wheel that stands turns its rim on a belt.
fn speed_of_terms(joint: &TouchJoint, bodies: &[BodyState]) -> f64 {
    let touch = touch_motion(joint, bodies);
    let turning = |end: &Attachment| {
        let body = end.on(bodies);
        body.angular_velocity.norm() * (touch.point - body.position).norm()
    };
    let carried = if joint.is_belt() { belt(joint, bodies, &touch.normal).norm() } else { 0.0 };
    turning(&joint.a).max(turning(&joint.b)).max(carried)
}

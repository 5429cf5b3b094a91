//! One step in a mode: to an event, to an instant at which an effort changes its law, or as far as the step goes.
//!
//! ```text
//!     step h of what moves ─▶ φ on its dense output ─▶ none: accepted
//!                                                   └▶ a bracket: located (location.rs)
//! ```

use crate::events::effects::noted::{note_bound, side_of_bound};
use crate::events::effects::resting;
use crate::events::finding::detection::{Bracket, ONE_INSTANT};
use crate::events::finding::watched::{Seen, Watched};
use crate::events::integrator::Eventful;
use crate::events::modes::drives::displacement;
use crate::events::modes::instants::Evaluated;
use crate::events::modes::mode::{JointMode, MotorMode};
use crate::events::modes::piece::Piece;
use crate::events::modes::present::Present;
use crate::events::quiet::QUIET;
use crate::events::sliding::{JAM, Stopping};
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::energy::energy;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{StepError, StepOutcome};
use crate::mechanism::motion::state::State;

/// Events at one instant before a step is made without a look at their functions.
const FLIPS: usize = 20;
/// A step is made shorter this often at most before an element is believed to change its state at once.
const SHORTENED: usize = 8;
/// Each shorter step has this part of the length before.
const SHORTER: f64 = 1.0 / 16.0;
/// Such a step is no longer than this (s).
const BLIND: f64 = 1e-9;
/// A step that does not look at a pair or a limit is never longer than this (s); overlaps that it leaves are moved apart.
const BLIND_TO_BOUNDS: f64 = 1e-7;
/// Such a step is longer by this factor each time that its event left the mode unchanged.
const LONGER: f64 = 16.0;
/// The most such lengthenings.
const MOST_UNFOUNDED: i32 = 5;

impl Eventful {
    /// Makes one step towards `until`, which no effort's law changes before.
    pub(super) fn advance(&mut self, inputs: Inputs, state: &mut State, until: f64) -> Result<StepOutcome, StepError> {
        let since = state.time;
        let blind = self.flips.0 > FLIPS || self.looks_away;
        let shortest = BLIND.max(self.shortest(since));
        let until = if blind { until.min(since + self.blind_for(shortest)) } else { until };
        if !blind {
            self.ignored.clear();
        }
        self.origin.copy_from(state);
        self.last = self.current;
        self.evaluated = Evaluated::default();
        inputs.write_constant(&mut self.efforts);
        self.mode.add_constant_efforts(&self.elements, &mut self.efforts);
        self.note_slips(state);
        if !self.touching.pairs.is_empty() {
            match &mut self.stepped_in {
                Some(known) => known.copy_from(&self.mode),
                none => *none = Some(self.mode.clone()),
            }
        }
        let Stopping { until: soon, slow, straight } = self.soon_after_stop(inputs, since, state);
        let mut stopped = slow.filter(|_| straight && !blind);
        let given = self.bounded && !blind && until <= soon;
        let until = until.min(soon);
        let contacts = self.mode.contacts.len();
        let piece = &mut self.pieces[self.current];
        let unknowns = piece.moving.mechanism.velocity_count + 3 * contacts;
        if let Some(steps) = &mut piece.steps {
            steps.expect_instant(given);
        }
        piece.begin(&self.whole, inputs, &self.efforts, &self.origin);
        let mut triggers = Vec::new();
        let mut outcome = StepOutcome::default();
        // A step to a stop that is nearer than steps are long can be solved seldom, and would end here.
        if stopped.is_none() {
            match self.step_towards(inputs, since, until) {
                Ok(made) => outcome = made,
                // One that cannot be solved has a slip that turns before it stops, or begins again.
                Err(StepError::NotConverged { .. } | StepError::NotAccurate { .. }) if slow.is_some() => {
                    self.pieces[self.current].go_back(since, &self.recipe);
                    stopped = slow;
                }
                Err(error) => return Err(error),
            }
        }
        let mut bracket = match stopped {
            Some(slip) => Some(Bracket::at_start(slip, since)),
            None => self.detect(inputs, since, None),
        };
        // A function that is negative from the start on may be so on the dense output of a long step alone.
        for _ in 0..SHORTENED {
            let piece = &mut self.pieces[self.current];
            let shorter = since + SHORTER * (piece.small.time - since);
            if stopped.is_some() || bracket.is_none_or(|found| !found.at_start) || shorter - since < shortest {
                break;
            }
            piece.go_back(since, &self.recipe);
            let again = piece.step(&self.whole, inputs, shorter)?;
            outcome.iterations += again.iterations;
            outcome.rejected += 1 + again.rejected;
            outcome.exchange = again.exchange;
            bracket = self.detect(inputs, since, None);
        }
        if let Some(bracket) = bracket {
            triggers = self.end_at_first(inputs, bracket, shortest, &mut outcome)?;
        }
        let at_start = self.pieces[self.current].small.time <= since;
        let soon = at_start && !blind && self.go_ballistically(inputs, shortest, &mut triggers);
        let at_start = at_start && !soon;
        let piece = &mut self.pieces[self.current];
        if at_start {
            state.copy_from(&self.origin);
        } else {
            piece.moving.spread(&self.whole, &piece.small, state);
        }
        outcome.step = state.time - since;
        let kernel = if at_start || soon { Exchange::default() } else { outcome.exchange };
        outcome.exchange = self.exchanged(state, kernel, at_start || soon);
        if soon {
            let [before, after] = [&self.origin, &*state].map(|state| resting::energy(&self.whole, state).total());
            let taken = if self.slides() { &mut outcome.exchange.friction } else { &mut outcome.exchange.dissipated };
            *taken += before - after;
        }
        let overlaps = outcome.step > JAM && self.overlaps(state);
        let overlooks = !at_start && self.has_hole(since);
        if overlaps || overlooks || self.is_off_balance(inputs, state, &outcome.exchange) {
            if outcome.step <= JAM {
                return Err(StepError::NotAccurate { time: since, step: outcome.step });
            }
            self.note_labour(since, outcome.iterations, unknowns, false);
            self.pieces[self.current].go_back(since, &self.recipe);
            state.copy_from(&self.origin);
            let mut shorter = self.advance(inputs, state, since + SHORTER * outcome.step)?;
            shorter.iterations += outcome.iterations;
            shorter.rejected += 1 + outcome.rejected;
            return Ok(shorter);
        }
        if !at_start && !self.touching.pairs.is_empty() {
            self.bound_overlap(since);
            self.check_covers(inputs, since);
        }
        outcome.exchange.impacts += std::mem::take(&mut self.lost_at_start);
        for (memory, joint) in self.memory.joints.iter_mut().zip(&self.elements.joints) {
            memory.fastest = memory.fastest.max(joint.rate(state).abs());
        }
        self.fresh_joints.fill(false);
        self.fresh_motors.fill(false);
        self.fresh_pairs.fill(false);
        if !self.touching.pairs.is_empty() {
            self.placed.place(&self.whole, state, &mut self.bodies);
            let speeds = self.bodies.iter().map(|body| body.velocity.norm());
            self.memory.fastest = speeds.fold(self.memory.fastest, f64::max);
            self.memory.kinetic = self.memory.kinetic.max(energy(&self.whole, &self.bodies).kinetic);
        }
        let changed = self.meet_instants(inputs, state);
        if !triggers.is_empty() || changed || blind {
            self.flips = match self.flips {
                (count, time) if state.time - time <= ONE_INSTANT * time.abs().max(1.0) => (count + 1, time),
                _ => (0, state.time),
            };
            if at_start && !blind {
                self.cycle.see(&self.mode, state);
            } else {
                self.cycle.leave();
            }
            self.note_what_happens(&triggers, at_start);
            if triggers.is_empty() && blind {
                triggers = self.overlooked();
            }
            let mode = self.mode.clone();
            outcome.exchange.impacts += self.pass(inputs, state, &triggers);
            if at_start && self.flips.0 <= FLIPS && self.cycle.comes_back(&self.mode, state, self.memory.fastest) {
                self.crowding.count_repeated(FLIPS - self.flips.0);
                self.flips.0 = FLIPS + 1;
            }
            // An event that leaves the mode unchanged is an artefact of the dense output. The next step skips its function, and is longer each time
            // that this happens. A slip that was stopped has changed, even if it begins again.
            self.looks_away = at_start && stopped.is_none() && mode.is_like(&self.mode);
            if self.looks_away || self.flips.0 > FLIPS {
                self.unfounded = (self.unfounded + 1).min(MOST_UNFOUNDED);
            }
        }
        if !(blind || at_start) {
            self.unfounded = 0;
        }
        let quiet = triggers.is_empty() && !changed && inputs.feedback.is_none() && self.is_quiet(state);
        self.quiet = if quiet { self.quiet + 1 } else { 0 };
        if soon {
            // No step was made that has an inside.
            self.stepped_over = Some(state.clone());
        }
        if self.quiet >= QUIET {
            self.asleep = true;
            state.velocity.fill(0.0);
            self.enter(state);
        }
        self.steps += 1;
        self.stepped += outcome.step;
        self.note_labour(since, outcome.iterations, unknowns, !triggers.is_empty());
        Ok(outcome)
    }

    /// Counts the cost of a step from a time (s) on; given steps may be many between events.
    fn note_labour(&mut self, since: f64, iterations: usize, unknowns: usize, event: bool) {
        if self.recipe.tolerance().is_some() {
            self.crowding.labour(since, iterations, unknowns, event);
        }
    }

    /// How long a step may be that does not look at everything (s).
    fn blind_for(&self, shortest: f64) -> f64 {
        let length = shortest * LONGER.powi(self.unfounded);
        let bound = |watched: &Watched| matches!(watched, Watched::Approach(_) | Watched::Gap(..));
        if !self.touching.pairs.is_empty() && self.ignored.iter().any(bound) {
            length.min(shortest.max(BLIND_TO_BOUNDS))
        } else {
            length
        }
    }

    /// Notes the events of an instant: events that repeat there, or leave the mode unchanged, are not looked at in the next step.
    fn note_what_happens(&mut self, triggers: &[Watched], at_start: bool) {
        if !at_start {
            self.ignored.clear();
        }
        for trigger in triggers {
            if !self.ignored.contains(trigger) {
                self.ignored.push(*trigger);
            }
        }
        // Contacts of one pair that slide leave their features at about the same time: one step without looking goes beyond all of these borders.
        if at_start && triggers.iter().any(|trigger| matches!(trigger, Watched::Feature(_))) {
            let borders = self.watched.iter().filter(|watched| matches!(watched, Watched::Feature(_)));
            let more: Vec<Watched> = borders.filter(|border| !self.ignored.contains(border)).copied().collect();
            self.ignored.extend(more);
        }
    }

    /// The pairs that overlap at the end of a step that did not look at them.
    fn overlooked(&self) -> Vec<Watched> {
        let overlaps = |watched: &&Watched| match **watched {
            Watched::Approach(pair) => self.touching.distance(pair, &self.bodies) < 0.0,
            _ => false,
        };
        self.ignored.iter().filter(overlaps).copied().collect()
    }

    /// Takes other efforts from outside: the mode is decided anew if it cannot go on under them.
    pub(super) fn heed(&mut self, inputs: Inputs, state: &mut State) {
        if self.outside == inputs.efforts {
            return;
        }
        self.outside.clear();
        self.outside.extend_from_slice(inputs.efforts);
        if !self.goes_on_under(inputs, state) {
            self.lost_at_start += self.pass(inputs, state, &[]);
        }
    }

    /// Whether the mode goes on under efforts that have jumped: the forces that hold joints and contacts stay in their sets. A mode that was entered
    /// at this very instant was decided under the efforts before, and is decided anew.
    pub(super) fn goes_on_under(&mut self, inputs: Inputs, state: &State) -> bool {
        let held = self.mode.joints.iter().any(|joint| matches!(joint, JointMode::Held { .. }));
        if !held && self.mode.contacts.is_empty() {
            return true;
        }
        if self.asleep || self.undecided || self.flips.1 == state.time || self.left.is_none() {
            return false;
        }
        self.evaluated = Evaluated::default();
        let Eventful {
            whole,
            elements,
            touching,
            mode,
            response,
            pieces,
            current,
            holding,
            efforts,
            watched,
            bodies,
            slips,
            ..
        } = self;
        mode.efforts_at(elements, inputs, state.time, state, efforts);
        let present = Present { whole, elements, touching, mode, moving: &pieces[*current].moving };
        holding.evaluate(&present, response, state, efforts);
        if watched.contains(&Watched::Margin) {
            holding.evaluate_margin();
        }
        let time = state.time;
        let seen = Seen { elements, touching, mode, holding, since: time, time, state, bodies, slips };
        watched.iter().filter(|watched| watched.needs_efforts()).all(|watched| watched.value(&seen) >= 0.0)
    }

    /// At a given instant of a target or a tick: the efforts that begin there. Whether the mode has to be decided anew.
    fn meet_instants(&mut self, inputs: Inputs, state: &State) -> bool {
        let (before, now) = (self.origin.time, state.time);
        let (mut changed, mut jumped) = (false, false);
        for index in 0..self.elements.motors.len() {
            let next = self.elements.motors[index].next_instant(before);
            if (next - now).abs() > ONE_INSTANT * now.abs().max(1.0) {
                continue;
            }
            let mode = self.motor_mode(index, state);
            let follows = |mode: &MotorMode| matches!(mode, MotorMode::Given(_));
            // A new effort alone leaves the modes of moving joints unchanged.
            changed |= !(follows(&mode) && follows(&self.mode.motors[index])) && mode != self.mode.motors[index];
            self.note_bound_at_tick(index, mode, now);
            self.mode.motors[index] = mode;
            jumped = true;
        }
        changed || jumped && !self.goes_on_under(inputs, state)
    }

    /// Notes that a sampled motor reaches its bound at a tick (s), or comes back from it.
    fn note_bound_at_tick(&mut self, index: usize, mode: MotorMode, time: f64) {
        let motor = &self.elements.motors[index];
        if let (MotorMode::Given(before), MotorMode::Given(now)) = (self.mode.motors[index], mode) {
            note_bound(motor, [before, now].map(|effort| side_of_bound(motor, effort)), time, &mut self.events);
        }
    }

    /// The energy that went in and out in the step (J): the sums of the scheme for the reduced mechanism, told apart.
    fn exchanged(&mut self, end: &State, kernel: Exchange, nothing: bool) -> Exchange {
        if nothing {
            return Exchange::default();
        }
        let mut friction = 0.0;
        for (joint, mode) in self.elements.joints.iter().zip(&self.mode.joints) {
            if let JointMode::Free { sliding } = mode {
                let moved = displacement(&self.origin, end, joint.coordinate.position);
                friction += f64::from(*sliding) * moved * joint.friction;
            }
        }
        let Piece { drives, steps, small, small_start, .. } = &mut *self.pieces[self.current];
        let (given, taken) =
            steps.as_ref().map_or((0.0, 0.0), |own| drives.exchanged(own.as_ref(), small_start, small));
        // Without dampers it is all of the motors, and no rounding of a difference.
        let forces = &self.whole.forces;
        let damped = !forces.joint_dampers.is_empty() || forces.point_springs.iter().any(|spring| spring.damping > 0.0);
        let taken = if damped { taken } else { kernel.dissipated };
        Exchange {
            dissipated: kernel.dissipated - taken,
            work: kernel.work + friction + given - taken,
            friction: friction + kernel.friction,
            impacts: 0.0,
        }
    }
}

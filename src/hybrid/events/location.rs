//! Location of an event: the step is solved again with its length as an additional unknown, so that it ends at the event.
//!
//! ```text
//!     φ(q̄, v̄, t₀ + h) = 0:    h ← h − φ (h − h')/(φ − φ')           (h', φ') the attempt before
//! ```
//!
//! A bracket on the dense output of the step begins it, and each attempt ends a step of the scheme; φ̇ at its end is the slope in h but for terms of
//! the order of the scheme, so that a secant is as good as one more unknown in the equations of the stages. If an earlier root shows on the shortened
//! step, it is taken instead.

use crate::events::covered::SAME_END;
use crate::events::finding::detection::{Bracket, First, Looking, ONE_INSTANT, first_sign_change};
use crate::events::finding::watched::{BORDER, Watched};
use crate::events::integrator::Eventful;
use crate::events::jumps::{JUMP, Located};
use crate::events::modes::instants::Inside;
use crate::events::modes::tolerances::{AT_EVENT, STEEP_SLIP, rate_at_rest, slip_at_rest};
use crate::events::turning::{BEFORE_IT, Turned};
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Rejected, StepError, StepOutcome};
use crate::mechanism::motion::kinematics::place_bodies;

/// Attempts at the length of a step that ends at an event.
const ATTEMPTS: usize = 12;

/// The gap of a joint at the end of a step that ends at its limit is a root up to this part of its scale. Roots are located to 1e-15.
const NOT_LOCATED: f64 = 1e-9;
/// Force roots are located to this part of the rounding error, past the bound, so that the constraint releases immediately.
const WITHIN: f64 = 0.1;
/// A force has ended with the margin of all if it is below this many times its rounding and the rest of the margin together.
const TWICE: f64 = 2.0;
/// The rest of a located margin counts up to this many roundings.
const LEFT: f64 = 50.0;
/// The smallest value of a function has fallen if it is less than this part of its value before. The search for a root ends after `STALE` attempts in
/// which it has not fallen.
const FALLS: f64 = 0.8;
const STALE: usize = 3;
/// For slips the search ends in this way only in steps below this (s).
const SHORT: f64 = 1e-6;
/// The effort of a motor has a kink at its bound, and no jump. So its root is near enough if the impulse that is missed is at most this part of the
/// tolerance (over 1 m) of the impulse that the motor can give in the step.
const MISSED: f64 = 1e-3;
/// A joint that leaves its limit has a root at the start. Attempts that lead below this part of the first bracket tend to it.
const TO_START: f64 = 0.5;
/// For slips it also ends if the bracket is narrower than this part of the step.
const NARROW: f64 = 1e-2;

impl Eventful {
    /// The functions that may change their sign in the last step of the piece in use.
    fn candidates(&self, since: f64, which: &mut Vec<usize>) {
        let small = &self.workspaces.active().small;
        let length = small.time - since;
        let near = |watched: &Watched| match *watched {
            Watched::Gap(index, side) => {
                let joint = &self.model.elements.joints[index];
                let piece = &self.workspaces.active();
                let Some(own) = piece.moving.coordinate(&self.model.whole, joint.coordinate) else { return false };
                let (start, end) = (&piece.small_start, small);
                let fastest = start.velocity[own.freedom].abs().max(end.velocity[own.freedom].abs());
                let nearest = [start, end].map(|state| joint.gap(side, state.position[own.position]));
                // Twice what a cubic through both ends could do between them.
                nearest[0].min(nearest[1]) <= length * fastest + (nearest[0] - nearest[1]).abs()
            }
            _ => true,
        };
        which.clear();
        let looked_at = |watched: &Watched| !self.progress.repeats.ignored.contains(watched) && near(watched);
        // Gaps of pairs are looked for by distances and speeds.
        let others = Watched::after_gaps(&self.trial.watched)..self.trial.watched.len();
        which.extend(others.filter(|&index| looked_at(&self.trial.watched[index])));
    }

    /// Whether a joint begins the last step on this side of its room, up to a gap (rad or m).
    fn begins_at(&self, joint: usize, side: Side, gap: f64) -> bool {
        let of = &self.model.elements.joints[joint];
        of.gap(side, of.position(&self.trial.origin)) <= gap
    }

    /// The first bracket in which a function changes its sign in the last step; `known` is one that does at its end.
    pub(crate) fn detect(&mut self, inputs: Inputs, since: f64, known: Option<Bracket>) -> Option<Bracket> {
        let known = known.map(|known| (known, self.trial.watched[known.watched]));
        self.see_step(since);
        let known = known.map(|(known, of)| Bracket { watched: self.place_of(of, known.watched), ..known });
        let mut looking = std::mem::take(&mut self.trial.looking);
        let found = self.look(inputs, since, known.map(|known| known.watched), &mut looking);
        self.trial.looking = looking;
        if found.is_some_and(|found| found.at_start) {
            return found;
        }
        let end = self.workspaces.active().small.time;
        let ends = found.map_or(end, |found| found.root);
        // Pairs that close later are looked at in the step that is made again up to there.
        let before = if ends < end - SAME_END * (end - since) { ends } else { end };
        let contact = self.look_for_contacts(since, before, known);
        match (found, contact) {
            (Some(found), Some(contact)) => Some(if contact.root < found.root { contact } else { found }),
            (found, contact) => found.or(contact),
        }
    }

    /// The place of a function among the watched ones, to which gaps of pairs may have been added since it was here.
    fn place_of(&self, of: Watched, before: usize) -> usize {
        if self.trial.watched[before] == of {
            return before;
        }
        self.trial.watched.iter().position(|watched| *watched == of).unwrap_or(before)
    }

    /// The same, with room for it. Functions that ring keep their signs.
    fn look(&mut self, inputs: Inputs, since: f64, but: Option<usize>, looking: &mut Looking) -> Option<Bracket> {
        looking.ringing.clear();
        loop {
            let found = self.look_at_others(inputs, since, but, looking)?;
            if !self.rings(inputs, since, found.root, found.watched) {
                return Some(found);
            }
            looking.ringing.push(found.watched);
        }
    }

    /// The same, but for functions that are known to ring.
    fn look_at_others(
        &mut self,
        inputs: Inputs,
        since: f64,
        but: Option<usize>,
        looking: &mut Looking,
    ) -> Option<Bracket> {
        let Looking { which, zero, noise, room, ringing } = looking;
        self.candidates(since, which);
        self.see_forces();
        let skipped = |index: &usize| Some(*index) == but || ringing.contains(index);
        which.retain(|index| !skipped(index) && !self.is_foreseen(self.trial.watched[*index]));
        room.unclear = false;
        if which.is_empty() {
            return None;
        }
        zero.clear();
        zero.extend(which.iter().map(|&index| {
            self.trial.watched[index].nearly(AT_EVENT, &self.model.elements, &self.model.touching, &self.mode)
        }));
        noise.clear();
        noise.extend(which.iter().zip(&*zero).map(|(&index, &zero)| {
            let fresh = match self.trial.watched[index] {
                Watched::Gap(joint, side) => self.trial.fresh_joints[joint] && self.begins_at(joint, side, zero),
                Watched::Slide(joint) | Watched::Bears(joint, _) => self.trial.fresh_joints[joint],
                Watched::Margin => self.trial.fresh_joints.contains(&true) || self.trial.fresh_pairs.any(),
                Watched::Motor(motor, _) | Watched::Excess(motor) => self.trial.fresh_motors[motor],
                Watched::Approach(pair) | Watched::SlipsTogether(pair) => self.trial.fresh_pairs.holds(pair),
                Watched::Returns(unpressed) => self.trial.fresh_pairs.holds(self.mode.unpressed[unpressed].pair),
                Watched::Presses(contact)
                | Watched::Grips(contact)
                | Watched::Slips(contact)
                | Watched::Resists(contact, _)
                | Watched::Turns(contact, _)
                | Watched::Feature(contact) => self.trial.fresh_pairs.holds(self.mode.contacts[contact].contact.pair),
            };
            if fresh { f64::INFINITY } else { zero }
        }));
        let end = self.workspaces.active().small.time;
        let motors = &self.model.elements.motors;
        // Forces change little in a short span, but a joint may cross the room between its limits there.
        let may_meet = which.iter().any(|&index| matches!(self.trial.watched[index], Watched::Gap(..)));
        let first = if self.is_short_span() && !may_meet {
            First::Ends
        } else if self.model.whole.changes() || motors.iter().any(|motor| motor.target.as_formula().is_some()) {
            First::All
        } else {
            First::Thirds
        };
        let found = first_sign_change(room, which.len(), since, end, [zero, noise], first, |time, of, values| {
            self.evaluate(inputs, since, Inside::at(time), &which[of.clone()], values);
            // An unloaded contact does not part by roundings.
            for (value, &index) in values.iter_mut().zip(&which[of]) {
                if let Watched::Presses(contact) = self.trial.watched[index]
                    && self.trial.holding.is_unloaded(contact)
                {
                    *value = value.abs().max(f64::MIN_POSITIVE);
                }
            }
        });
        found.map(|found| Bracket { watched: which[found.watched], ..found })
    }

    /// Makes the step again so that it ends at the first event; returns the functions that are zero there.
    pub(crate) fn locate(
        &mut self,
        inputs: Inputs,
        first: Bracket,
        outcome: &mut StepOutcome,
    ) -> Result<Located, StepError> {
        let since = self.trial.origin.time;
        let mut bracket = first;
        for _ in 0..=self.trial.watched.len().min(ATTEMPTS) {
            if bracket.at_start {
                self.workspaces.active_mut().go_back(since, &self.model.recipe);
                return Ok(Located::At(self.overlaps_at_start(bracket.watched)));
            }
            self.trial.parts.clear();
            if !self.end_at(inputs, since, bracket, outcome)? {
                let force = self.trial.watched[bracket.watched].is_force();
                return Ok(Located::Jumps(if force { Rejected::ForceJump } else { Rejected::NotSmooth }));
            }
            let end = self.workspaces.active().small.time;
            let own = self.trial.watched[bracket.watched];
            let found = self.detect(inputs, since, Some(bracket));
            bracket.watched = self.place_of(own, bracket.watched);
            match found {
                Some(earlier) if earlier.root < end - SAME_END * (end - since) => bracket = earlier,
                _ => break,
            }
        }
        let all: Vec<usize> = (0..self.trial.watched.len()).collect();
        let mut values = vec![0.0; all.len()];
        let end = self.workspaces.active().small.time;
        self.evaluate(inputs, since, Inside::at(end), &all, &mut values);
        let state = &self.trial.sample;
        let margin = (self.trial.watched[bracket.watched] == Watched::Margin).then(|| values[bracket.watched].abs());
        let meets = |index: usize| {
            let watched = self.trial.watched[index];
            let allowed = match (watched, margin) {
                // Roundings of what the bodies weigh are all that is left of it.
                (Watched::Presses(contact), Some(_)) if self.trial.holding.is_unloaded(contact) => f64::INFINITY,
                // The smallest forces are the margin, and end with it: these contacts part together.
                (Watched::Presses(_), Some(left)) => {
                    let rounding = watched.rounding(&self.trial.holding);
                    TWICE * (rounding + left.min(LEFT * rounding))
                }
                // Those that get there at the same time; the top of a small bounce does not.
                (Watched::Gap(joint, _), _) => {
                    self.model.elements.joints[joint].rate(state).abs() * ONE_INSTANT * end.abs().max(1.0)
                }
                // Joints that stop together have come from rates; one that creeps to its rest, against a hard damper, goes on.
                (Watched::Slide(joint), _) => {
                    let began = self.model.elements.joints[joint].rate(&self.trial.origin).abs();
                    (AT_EVENT * began.min(1.0)).max(rate_at_rest(self.memory.joints[joint].fastest))
                }
                _ => watched.nearly(AT_EVENT, &self.model.elements, &self.model.touching, &self.mode),
            };
            index == bracket.watched || values[index].abs() <= allowed
        };
        let all = (0..self.trial.watched.len()).filter(|&index| meets(index)).map(|index| self.trial.watched[index]);
        let mut all: Vec<Watched> = all.collect();
        all.extend(self.trial.parts.iter().filter(|part| !all.contains(part)).copied().collect::<Vec<_>>());
        self.leave_unloaded(inputs, since, bracket.watched, &mut all);
        let turned: Vec<Option<Turned>> = all.iter().map(|watched| self.turns(since, *watched)).collect();
        if end - since > SHORT && turned.contains(&Some(Turned::Slowly)) {
            return Ok(Located::Passes { length: BEFORE_IT * (end - since) });
        }
        let mut turned = turned.into_iter();
        all.retain(|_| turned.next().flatten() != Some(Turned::Fast));
        Ok(Located::At(all))
    }

    /// The function that is negative from the start on, and all pairs that overlap and contacts that have left their features there.
    fn overlaps_at_start(&mut self, negative: usize) -> Vec<Watched> {
        place_bodies(&self.model.whole, &self.trial.origin, &mut self.trial.bodies);
        self.trial.forget_looks();
        let overlaps = |index: usize| match self.trial.watched[index] {
            Watched::Approach(pair) => {
                self.model.touching.overlaps(pair, &self.trial.bodies, self.model.touching.pairs[pair].within(AT_EVENT))
            }
            Watched::Feature(contact) => {
                let contact = &self.mode.contacts[contact].contact;
                self.model.touching.margin(contact, &self.trial.bodies)
                    < -self.model.touching.pairs[contact.pair].within(BORDER)
            }
            _ => false,
        };
        let all = (0..self.trial.watched.len()).filter(|&index| index == negative || overlaps(index));
        all.map(|index| self.trial.watched[index]).collect()
    }

    /// Whether a step of this length (s) ends near enough behind the bound of a motor, whose effort beyond it and the time since make this product
    /// [N s or N m s].
    fn is_near_enough(&self, watched: usize, product: f64, length: f64) -> bool {
        let (Watched::Motor(motor, _) | Watched::Excess(motor)) = self.trial.watched[watched] else { return false };
        let part = MISSED * self.model.recipe.tolerance().unwrap_or(0.0);
        0.5 * product.abs() <= part * self.model.elements.motors[motor].max_effort * length
    }

    /// Makes the step again with the length at which a function is zero; false if the function has no zero there, but jumps, or the step does not
    /// show it.
    fn end_at(
        &mut self,
        inputs: Inputs,
        since: f64,
        bracket: Bracket,
        outcome: &mut StepOutcome,
    ) -> Result<bool, StepError> {
        let which = [bracket.watched];
        let full = self.workspaces.active().small.time - since;
        let bounded = self.ends_at_change(since, since + full);
        let scale = self.trial.watched[bracket.watched].scale(&self.model.elements, &self.model.touching, &self.mode);
        let (mut low, mut high) = (bracket.low - since, (bracket.high - since).max(bracket.root - since));
        let mut length = bracket.root - since;
        let mut slope = bracket.slope;
        // A slip has a direction before it stops, but not at the stop: its end is reached from before the stop.
        let stops = self.trial.watched[bracket.watched].is_braked();
        if stops {
            let before = if bracket.low > since { bracket.low - since } else { 0.5 * length };
            slope = 0.0;
            length = before;
        }
        let mut before: Option<(f64, f64)> = None;
        // Whether an end beyond the root is known; the smallest value so far, and attempts since it fell.
        let (mut passed, mut smallest, mut stale) = (false, f64::INFINITY, 0);
        // The gap of a joint at the end of the last attempt (m or rad).
        let is_limit = matches!(self.trial.watched[bracket.watched], Watched::Gap(..));
        let mut gap = 0.0;
        let slides = matches!(self.trial.watched[bracket.watched], Watched::Slide(_));
        // Whether an end before the root is known.
        let (forces, mut preceded) = (self.trial.watched[bracket.watched].is_force(), false);
        for attempt in 0..ATTEMPTS {
            // So near to the start it is there.
            if length <= self.shortest(since) {
                self.see_what_parts(inputs, since, bracket.watched);
                self.workspaces.active_mut().go_back(since, &self.model.recipe);
                return Ok(true);
            }
            let piece = self.workspaces.active_mut();
            let done = match piece.again(&self.model.whole, inputs, since, length) {
                Ok(done) => done,
                // Near the stop of a slip a shorter step may be one that can be solved.
                Err(StepError::NotConverged { .. }) if stops && attempt + 1 < ATTEMPTS => {
                    piece.go_back(since, &self.model.recipe);
                    high = high.min(length);
                    passed = true;
                    let done = self.step_towards(inputs, since, since + 0.5 * (low + length))?;
                    length = self.workspaces.active().small.time - since;
                    done
                }
                Err(error) => return Err(error),
            };
            outcome.take_again(&done);
            outcome.cost.located += 1;
            let mut value = [0.0];
            let end = self.workspaces.active().small.time;
            self.evaluate(inputs, since, Inside::at(end), &which, &mut value);
            let [value] = value;
            gap = if is_limit { value } else { 0.0 };
            if let Some((other, there)) = before
                && other != length
                && value != there
                && (!stops || value.abs() > STEEP_SLIP * self.memory.fastest)
            {
                slope = (value - there) / (length - other);
            }
            if stops && value > 0.0 {
                // The direction of one that has stopped is noise.
                if value > slip_at_rest(self.memory.fastest) {
                    self.turn_slips();
                }
                if before.is_none() {
                    slope = -value / (bracket.root - since - length).max(f64::MIN_POSITIVE);
                }
            }
            let noise = (WITHIN * self.trial.watched[bracket.watched].rounding(&self.trial.holding)).max(2e-16 * scale);
            if value.abs() <= noise || slope == 0.0 || stops && value.abs() <= slip_at_rest(self.memory.fastest) {
                break;
            }
            stale = if value.abs() < FALLS * smallest { 0 } else { stale + 1 };
            smallest = smallest.min(value.abs());
            // It is noise, or has no root here. In a long step the attempts may still find the stop of a slip that turns.
            if stale >= STALE && (!stops || full < SHORT || high - low < NARROW * full) {
                if forces && preceded && value < -JUMP * noise {
                    return Ok(false);
                }
                break;
            }
            let change = -value / slope;
            if value < 0.0 && self.is_near_enough(bracket.watched, value * change, full) {
                break;
            }
            // Lengths of steps are known better than times late in a run.
            if change.abs() <= 0.5 * f64::EPSILON * full {
                break;
            }
            if before.is_some_and(|(_, there)| attempt > 3 && value.abs() >= there.abs() && value.abs() < 1e-13 * scale)
            {
                break;
            }
            if value > 0.0 {
                preceded = true;
                low = low.max(length)
            } else {
                high = high.min(length);
                passed = true;
            }
            before = Some((length, value));
            let wanted = length + change;
            // The dense output that has bracketed the root may be off by its error; the rates of a joint at the ends of two steps are not. The slope of
            // two roundings leads beyond these.
            let beside = if slides && preceded && passed { 0.0 } else { 1e-3 * full };
            let (from, to) = (low.min(length) - beside, high.max(length) + beside);
            // Beyond an instant at which forces change they are others.
            let to = if bounded { to.min(full) } else { to };
            // The dense output of a long step has dipped below a limit that the joint leaves.
            if is_limit && !passed && wanted < TO_START * (bracket.low - since) {
                return Ok(false);
            }
            length = if wanted > from.max(0.0) && wanted < to {
                wanted
            } else if stops && !passed && wanted >= to && high < full {
                // The step could be made to its end, and the stop is further than the dense output says.
                high = full;
                wanted.min(full)
            } else if passed || stops {
                0.5 * (low + high)
            } else if length < high {
                high
            } else {
                // The dense output shows a root that does not exist on steps that end there.
                if forces && value > JUMP * noise {
                    return Ok(false);
                }
                break;
            };
        }
        Ok(gap.abs() <= NOT_LOCATED * scale)
    }
}

//! One step in a mode: to an event, to an instant at which an effort changes its law, or as far as the step goes.
//!
//! ```text
//!     step h of what moves ─▶ φ on its dense output ─▶ none: accepted
//!                                                   └▶ a bracket: again with h − φ/φ̇, until φ(q̄, v̄, t₀ + h) = 0 to rounding
//!                                                                 earlier ones? the same again
//! ```
//!
//! φ̇ at the end of the step is its slope in h but for terms of the order of the scheme, so that a secant is as good as one more unknown.

use crate::events::detection::{Bracket, first_sign_change};
use crate::events::drives::displacement;
use crate::events::integrator::{Eventful, Piece};
use crate::events::mode::{JointMode, MotorMode};
use crate::events::watched::Watched;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::event::{Event, FrictionState, JointStatus, Side};
use crate::mechanism::motion::inputs::{ChangingEfforts, Inputs};
use crate::mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::stepping::recipe::{Recipe, Steps};

/// Events at one instant before a step is made without looking for any.
const FLIPS: usize = 20;
/// So often a step is made shorter,
const SHORTENED: usize = 8;
/// each time by this factor, before an element is believed to change its state at once.
const SHORTER: f64 = 1.0 / 16.0;
/// That step is no longer than this (s).
const BLIND: f64 = 1e-9;
/// Attempts at the length of a step that ends at an event.
const ATTEMPTS: usize = 12;
/// Functions this near to zero at an event, relative to their size, belong to it.
const TOGETHER: f64 = 1e-11;
/// Instants that are nearer to each other are one (relative to one second, or to the time if that is more).
const ONE_INSTANT: f64 = 1e-12;

impl Eventful {
    /// Makes one step towards `until`, which no effort's law changes before.
    fn advance(&mut self, inputs: Inputs, state: &mut State, until: f64) -> Result<StepOutcome, StepError> {
        let since = state.time;
        let blind = self.flips.0 > FLIPS;
        let until = if blind { until.min(since + BLIND) } else { until };
        self.origin.copy_from(state);
        self.last = self.current;
        self.efforts.fill(0.0);
        self.efforts[..inputs.efforts.len()].copy_from_slice(inputs.efforts);
        self.mode.add_constant_efforts(&self.elements, &mut self.efforts);
        let piece = &mut self.pieces[self.current];
        piece.begin(&self.whole, &self.efforts, since);
        let mut outcome = piece.step(until)?;
        let mut triggers = Vec::new();
        let mut bracket = if blind { None } else { self.detect(inputs, since, None) };
        // A function that is negative from the start on may be so on the dense output of a long step alone.
        for _ in 0..SHORTENED {
            let piece = &mut self.pieces[self.current];
            let shorter = since + SHORTER * (piece.small.time - since);
            if bracket.is_none_or(|found| !found.at_start) || shorter - since < BLIND {
                break;
            }
            piece.go_back(since, &self.recipe);
            let again = piece.step(shorter)?;
            outcome.iterations += again.iterations;
            outcome.rejected += 1 + again.rejected;
            outcome.exchange = again.exchange;
            bracket = self.detect(inputs, since, None);
        }
        if let Some(bracket) = bracket {
            triggers = self.locate(inputs, bracket, &mut outcome)?;
        }
        let piece = &mut self.pieces[self.current];
        let at_start = piece.small.time <= since;
        if at_start {
            state.copy_from(&self.origin);
        } else {
            piece.moving.spread(&self.whole, &piece.small, state);
        }
        outcome.step = state.time - since;
        let kernel = if at_start { Exchange::default() } else { outcome.exchange };
        outcome.exchange = self.exchanged(state, kernel, at_start);
        outcome.exchange.impacts += std::mem::take(&mut self.lost_at_start);
        for (memory, joint) in self.memory.joints.iter_mut().zip(&self.elements.joints) {
            memory.fastest = memory.fastest.max(joint.rate(state).abs());
        }
        self.fresh_joints.fill(false);
        self.fresh_motors.fill(false);
        let changed = self.meet_instants(state);
        if !triggers.is_empty() || changed || blind {
            self.flips = match self.flips {
                (count, time) if state.time - time <= ONE_INSTANT * time.abs().max(1.0) => (count + 1, time),
                _ => (0, state.time),
            };
            outcome.exchange.impacts += self.pass(inputs, state, &triggers);
        }
        self.steps += 1;
        self.stepped += outcome.step;
        Ok(outcome)
    }

    /// Other efforts from outside: what joints at rest do is decided anew.
    fn heed(&mut self, inputs: Inputs, state: &mut State) {
        if self.outside == inputs.efforts {
            return;
        }
        self.outside.clear();
        self.outside.extend_from_slice(inputs.efforts);
        if self.mode.joints.iter().any(|joint| matches!(joint, JointMode::Held { .. })) {
            self.lost_at_start += self.pass(inputs, state, &[]);
        }
    }

    /// At a given instant of a target or a tick: the efforts that begin there. Whether joints at rest have to be decided anew.
    fn meet_instants(&mut self, state: &State) -> bool {
        let (before, now) = (self.origin.time, state.time);
        let mut changed = false;
        for index in 0..self.elements.motors.len() {
            let next = self.elements.motors[index].next_instant(before);
            if (next - now).abs() > ONE_INSTANT * now.abs().max(1.0) {
                continue;
            }
            let mode = self.motor_mode(index, state);
            let follows = |mode: &MotorMode| matches!(mode, MotorMode::Given(_));
            // Another effort alone asks nothing of joints that move.
            changed |= !(follows(&mode) && follows(&self.mode.motors[index])) && mode != self.mode.motors[index];
            self.mode.motors[index] = mode;
            changed |= self.mode.joints.iter().any(|joint| matches!(joint, JointMode::Held { .. }));
        }
        changed
    }

    /// The energy that went in and out in the step (J): what the scheme has summed for what moves, told apart.
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
        let Piece { drives, lobatto, small, small_start, .. } = &mut self.pieces[self.current];
        let (given, taken) = lobatto.as_ref().map_or((0.0, 0.0), |own| drives.exchanged(own, small_start, small));
        Exchange {
            dissipated: kernel.dissipated - taken,
            work: kernel.work + friction + given - taken,
            friction,
            impacts: 0.0,
        }
    }

    /// The functions that may change their sign in the last step of the piece in use.
    fn candidates(&self, since: f64) -> Vec<usize> {
        let small = &self.pieces[self.current].small;
        let length = small.time - since;
        let near = |watched: &Watched| match *watched {
            Watched::Gap(index, side) => {
                let joint = &self.elements.joints[index];
                let piece = &self.pieces[self.current];
                let Some(own) = piece.moving.coordinate(&self.whole, joint.coordinate) else { return false };
                let (start, end) = (&piece.small_start, small);
                let fastest = start.velocity[own.freedom].abs().max(end.velocity[own.freedom].abs());
                let nearest = [start, end].map(|state| joint.gap(side, state.position[own.position]));
                // Twice what a cubic through both ends could do between them.
                nearest[0].min(nearest[1]) <= length * fastest + (nearest[0] - nearest[1]).abs()
            }
            _ => true,
        };
        self.watched.iter().enumerate().filter(|(_, watched)| near(watched)).map(|(index, _)| index).collect()
    }

    /// Where a function changes its sign first in the last step; `but` is one that is known.
    fn detect(&mut self, inputs: Inputs, since: f64, but: Option<usize>) -> Option<Bracket> {
        let mut which = self.candidates(since);
        which.retain(|index| Some(*index) != but);
        if which.is_empty() {
            return None;
        }
        let noise: Vec<f64> = which
            .iter()
            .map(|&index| {
                let watched = self.watched[index];
                let fresh = match watched {
                    Watched::Gap(joint, _) | Watched::Slide(joint) | Watched::Bears(joint, _) => {
                        self.fresh_joints[joint]
                    }
                    Watched::Margin => self.fresh_joints.contains(&true),
                    Watched::Motor(motor, _) | Watched::Excess(motor) => self.fresh_motors[motor],
                };
                if fresh { f64::INFINITY } else { TOGETHER * watched.scale(&self.elements) }
            })
            .collect();
        let end = self.pieces[self.current].small.time;
        let found = first_sign_change(which.len(), since, end, &noise, |time, values| {
            self.evaluate(inputs, since, time, &which, values);
        })?;
        Some(Bracket { watched: which[found.watched], ..found })
    }

    /// The values of some functions at a time of the last step.
    fn evaluate(&mut self, inputs: Inputs, since: f64, time: f64, which: &[usize], values: &mut [f64]) {
        let Eventful { whole, elements, mode, response, pieces, current, holding, sample, watched, origin, .. } = self;
        let piece = &mut pieces[*current];
        sample.copy_from(origin);
        piece.place(whole, time, sample);
        if which.iter().any(|&index| watched[index].needs_efforts()) {
            let mut efforts = vec![0.0; whole.velocity_count];
            efforts[..inputs.efforts.len()].copy_from_slice(inputs.efforts);
            mode.add_constant_efforts(elements, &mut efforts);
            mode.add_motor_efforts(elements, since, time, sample, &mut efforts);
            holding.evaluate(whole, elements, mode, &piece.moving, response, sample, &efforts);
        }
        for (value, &index) in values.iter_mut().zip(which) {
            *value = watched[index].value(elements, mode, holding, since, time, sample);
        }
    }

    /// Makes the step again so that it ends at the first event; returns the functions that are zero there.
    fn locate(&mut self, inputs: Inputs, first: Bracket, outcome: &mut StepOutcome) -> Result<Vec<Watched>, StepError> {
        let since = self.origin.time;
        let mut bracket = first;
        for _ in 0..=self.watched.len().min(ATTEMPTS) {
            if bracket.at_start {
                self.pieces[self.current].go_back(since, &self.recipe);
                return Ok(vec![self.watched[bracket.watched]]);
            }
            self.end_at(inputs, since, bracket, outcome)?;
            let end = self.pieces[self.current].small.time;
            match self.detect(inputs, since, Some(bracket.watched)) {
                Some(earlier) if earlier.root < end - 1e-9 * (end - since) => bracket = earlier,
                _ => break,
            }
        }
        let all: Vec<usize> = (0..self.watched.len()).collect();
        let mut values = vec![0.0; all.len()];
        let end = self.pieces[self.current].small.time;
        self.evaluate(inputs, since, end, &all, &mut values);
        let state = &self.sample;
        let meets = |index: usize| {
            let watched = self.watched[index];
            let allowed = match watched {
                // Those that get there at the same time; the top of a small bounce does not.
                Watched::Gap(joint, _) => {
                    self.elements.joints[joint].rate(state).abs() * ONE_INSTANT * end.abs().max(1.0)
                }
                _ => TOGETHER * watched.scale(&self.elements),
            };
            index == bracket.watched || values[index].abs() <= allowed
        };
        Ok((0..self.watched.len()).filter(|&index| meets(index)).map(|index| self.watched[index]).collect())
    }

    /// Makes the step again with the length at which a function is zero.
    fn end_at(
        &mut self,
        inputs: Inputs,
        since: f64,
        bracket: Bracket,
        outcome: &mut StepOutcome,
    ) -> Result<(), StepError> {
        let which = [bracket.watched];
        let full = self.pieces[self.current].small.time - since;
        let scale = self.watched[bracket.watched].scale(&self.elements);
        let (mut low, mut high) = (bracket.low - since, (bracket.high - since).max(bracket.root - since));
        let mut length = bracket.root - since;
        let mut slope = bracket.slope;
        let mut before: Option<(f64, f64)> = None;
        for attempt in 0..ATTEMPTS {
            let done = self.pieces[self.current].again(since, length)?;
            outcome.iterations += done.iterations;
            outcome.exchange = done.exchange;
            outcome.rejected += usize::from(attempt == 0);
            let mut value = [0.0];
            let end = self.pieces[self.current].small.time;
            self.evaluate(inputs, since, end, &which, &mut value);
            let [value] = value;
            if let Some((other, there)) = before
                && other != length
                && value != there
            {
                slope = (value - there) / (length - other);
            }
            if value.abs() <= 2e-16 * scale || slope == 0.0 {
                break;
            }
            let change = -value / slope;
            // Shorter than the time can tell.
            if change.abs() <= 0.5 * f64::EPSILON * end.abs().max(full) {
                break;
            }
            if before.is_some_and(|(_, there)| attempt > 3 && value.abs() >= there.abs() && value.abs() < 1e-13 * scale)
            {
                break;
            }
            if value > 0.0 {
                low = low.max(length)
            } else {
                high = high.min(length)
            }
            before = Some((length, value));
            let wanted = length + change;
            // The dense output that has bracketed the root may be off by its error.
            let (from, to) = (low.min(length) - 1e-3 * full, high.max(length) + 1e-3 * full);
            length = if wanted > from.max(0.0) && wanted < to { wanted } else { 0.5 * (low + high) };
            // So near to the start it is there.
            if length <= 1e-14 * since.abs().max(1.0) {
                self.pieces[self.current].go_back(since, &self.recipe);
                break;
            }
        }
        Ok(())
    }
}

impl Piece {
    /// A step of what moves begins at a time (s), under these efforts on the whole.
    fn begin(&mut self, whole: &Mechanism, efforts: &[f64], since: f64) {
        self.drives.begin(since);
        self.small.time = since;
        self.moving.gather_velocities(whole, efforts, &mut self.small_efforts);
        self.small_start.copy_from(&self.small);
    }

    /// Makes it, towards `until`.
    fn step(&mut self, until: f64) -> Result<StepOutcome, StepError> {
        let Piece { moving, drives, lobatto, small, small_efforts, .. } = self;
        let changing = drives.change().then_some(&*drives as &dyn ChangingEfforts);
        let inputs = Inputs { efforts: small_efforts, changing };
        match lobatto {
            Some(lobatto) => lobatto.step(&moving.mechanism, inputs, small, until),
            None => {
                let step = until - small.time;
                small.time = until;
                Ok(StepOutcome { step, ..StepOutcome::default() })
            }
        }
    }

    /// Makes it again with another length (s).
    fn again(&mut self, since: f64, length: f64) -> Result<StepOutcome, StepError> {
        let Piece { moving, drives, lobatto, small, small_efforts, .. } = self;
        let changing = drives.change().then_some(&*drives as &dyn ChangingEfforts);
        let inputs = Inputs { efforts: small_efforts, changing };
        match lobatto {
            Some(lobatto) => lobatto.again(&moving.mechanism, inputs, small, length),
            None => {
                small.time = since + length;
                Ok(StepOutcome { step: length, ..StepOutcome::default() })
            }
        }
    }

    /// Throws the step away.
    fn go_back(&mut self, since: f64, recipe: &Recipe) {
        let Piece { small, small_start, lobatto, .. } = self;
        small.copy_from(small_start);
        if let (Some(lobatto), Steps::Chosen { .. }) = (lobatto, recipe.steps) {
            lobatto.keep_pace(lobatto.step_pace(since), since);
        }
    }

    /// Puts what moves where it was at a time of the last step (s).
    fn place(&mut self, whole: &Mechanism, time: f64, state: &mut State) {
        let Piece { moving, lobatto, small, small_start, small_position, small_velocity, .. } = self;
        state.time = time;
        let Some(lobatto) = lobatto else { return };
        for (at, of) in [(small_start.time, &*small_start), (small.time, &*small)] {
            if time == at {
                moving.spread(whole, of, state);
                return;
            }
        }
        lobatto.dense(&moving.mechanism, time, small_position, small_velocity);
        moving.spread_positions(whole, small_position, &mut state.position);
        state.compensation.fill(0.0);
        moving.spread_velocities(whole, small_velocity, &mut state.velocity);
    }
}

impl Integrator for Eventful {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let moved = self.left.as_ref().is_none_or(|left| left != state);
        if moved || self.is_other(mechanism) {
            self.begin(mechanism, inputs, state)?;
        }
        self.heed(inputs, state);
        let next = self.next_instant(state.time, until);
        let mut outcome = self.advance(inputs, state, next)?;
        // What is left is less than the time can tell.
        if until - state.time < ONE_INSTANT * until.abs().max(1.0) && state.time != until {
            outcome.step += until - state.time;
            state.time = until;
            self.pieces[self.current].small.time = until;
        }
        match &mut self.left {
            Some(left) => left.copy_from(state),
            none => *none = Some(state.clone()),
        }
        Ok(outcome)
    }

    fn dense(&mut self, _mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let Eventful { whole, pieces, last, sample, origin, .. } = self;
        sample.copy_from(origin);
        let piece = &mut pieces[*last];
        let Piece { moving, lobatto, small_position, small_velocity, .. } = piece;
        if let Some(lobatto) = lobatto {
            lobatto.dense(&moving.mechanism, time, small_position, small_velocity);
            moving.spread_positions(whole, small_position, &mut sample.position);
            moving.spread_velocities(whole, small_velocity, &mut sample.velocity);
        }
        position.copy_from_slice(&sample.position);
        velocity.copy_from_slice(&sample.velocity);
    }

    fn description(&self) -> MethodDescription {
        let lobatto = self.pieces.get(self.current).and_then(|piece| piece.lobatto.as_ref());
        let mut description = lobatto.map_or_else(|| self.idle.clone(), Integrator::description);
        if description.adaptive {
            description.step = self.stepped / self.steps.max(1) as f64;
        }
        description
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        events.append(&mut self.events);
    }

    fn joint_status(&self, _mechanism: &Mechanism, state: &State, body: usize) -> JointStatus {
        let mut status = JointStatus::default();
        for (joint, mode) in self.elements.joints.iter().zip(&self.mode.joints) {
            let Some(member) = joint.members.iter().find(|member| member.coordinate.body == body) else { continue };
            let held = if let JointMode::Held { on } = *mode { Some(on) } else { None };
            let own =
                |side: Side| if (member.factor > 0.0) == (side == Side::Lower) { Side::Lower } else { Side::Upper };
            status.limit = held.flatten().filter(|&side| joint.owner(side) == body).map(own);
            let friction = if held.is_some() { FrictionState::Stuck } else { FrictionState::Sliding };
            status.friction = member.rubs.then_some(friction);
        }
        for (motor, mode) in self.elements.motors.iter().zip(&self.mode.motors) {
            let at = motor.coordinate;
            if at.body != body {
                continue;
            }
            status.effort = Some(match *mode {
                MotorMode::Given(effort) => effort,
                _ => motor.effort(state.time, state.position[at.position], state.velocity[at.freedom]),
            });
        }
        status
    }
}

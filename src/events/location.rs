//! The location of an event: the step made again, with its length as one more unknown, so that it ends there.
//!
//! ```text
//!     φ(q̄, v̄, t₀ + h) = 0:    h ← h − φ (h − h')/(φ − φ')           (h', φ') the attempt before
//! ```
//!
//! A bracket on the dense output of the step begins it, and each attempt ends a step of the scheme; φ̇ at its end is the slope in h but for terms of the
//! order of the scheme, so that a secant is as good as one more unknown in the equations of the stages. Where an earlier root
//! shows on the shortened step it is taken instead.

use crate::events::detection::{Bracket, Looking, ONE_INSTANT, first_sign_change};
use crate::events::holding::Present;
use crate::events::integrator::Eventful;
use crate::events::watched::Watched;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{StepError, StepOutcome};

/// Attempts at the length of a step that ends at an event.
const ATTEMPTS: usize = 12;
/// Functions this near to zero at an event, relative to their size, belong to it.
const TOGETHER: f64 = 1e-11;

impl Eventful {
    /// The functions that may change their sign in the last step of the piece in use.
    fn candidates(&self, since: f64, which: &mut Vec<usize>) {
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
        which.clear();
        which.extend(self.watched.iter().enumerate().filter(|(_, watched)| near(watched)).map(|(index, _)| index));
    }

    /// Where a function changes its sign first in the last step; `but` is one that is known.
    pub(super) fn detect(&mut self, inputs: Inputs, since: f64, but: Option<usize>) -> Option<Bracket> {
        let mut looking = std::mem::take(&mut self.looking);
        let found = self.look(inputs, since, but, &mut looking);
        self.looking = looking;
        found
    }

    /// The same, with room for it.
    fn look(&mut self, inputs: Inputs, since: f64, but: Option<usize>, looking: &mut Looking) -> Option<Bracket> {
        let Looking { which, noise, room } = looking;
        self.candidates(since, which);
        which.retain(|index| Some(*index) != but);
        if which.is_empty() {
            return None;
        }
        noise.clear();
        noise.extend(which.iter().map(|&index| {
            let watched = self.watched[index];
            let fresh = match watched {
                Watched::Gap(joint, _) | Watched::Slide(joint) | Watched::Bears(joint, _) => self.fresh_joints[joint],
                Watched::Margin => self.fresh_joints.contains(&true),
                Watched::Motor(motor, _) | Watched::Excess(motor) => self.fresh_motors[motor],
            };
            if fresh { f64::INFINITY } else { TOGETHER * watched.scale(&self.elements) }
        }));
        let end = self.pieces[self.current].small.time;
        let found = first_sign_change(room, which.len(), since, end, noise, |time, values| {
            self.evaluate(inputs, since, time, which, values);
        })?;
        Some(Bracket { watched: which[found.watched], ..found })
    }

    /// The values of some functions at a time of the last step.
    fn evaluate(&mut self, inputs: Inputs, since: f64, time: f64, which: &[usize], values: &mut [f64]) {
        let Eventful {
            whole,
            elements,
            mode,
            response,
            pieces,
            current,
            holding,
            sample,
            watched,
            origin,
            efforts,
            ..
        } = self;
        let piece = &mut pieces[*current];
        sample.copy_from(origin);
        piece.place(whole, time, sample);
        if which.iter().any(|&index| watched[index].needs_efforts()) {
            efforts.fill(0.0);
            efforts[..inputs.efforts.len()].copy_from_slice(inputs.efforts);
            mode.add_constant_efforts(elements, efforts);
            mode.add_motor_efforts(elements, since, time, sample, efforts);
            let present = Present { whole, elements, mode, moving: &piece.moving };
            holding.evaluate(&present, response, sample, efforts);
        }
        for (value, &index) in values.iter_mut().zip(which) {
            *value = watched[index].value(elements, mode, holding, since, time, sample);
        }
    }

    /// Makes the step again so that it ends at the first event; returns the functions that are zero there.
    pub(super) fn locate(
        &mut self,
        inputs: Inputs,
        first: Bracket,
        outcome: &mut StepOutcome,
    ) -> Result<Vec<Watched>, StepError> {
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
            // So near to the start it is there.
            if length <= 1e-14 * since.abs().max(1.0) {
                self.pieces[self.current].go_back(since, &self.recipe);
                break;
            }
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
            // Lengths of steps are known better than times late in a run.
            if change.abs() <= 0.5 * f64::EPSILON * full {
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
        }
        Ok(())
    }
}

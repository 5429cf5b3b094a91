//! The directions in which contacts begin to slide from rest, with their derivatives.
//!
//! A contact without slip begins to slide in the direction d in which its slip is accelerated, under the friction −μ λ d that brakes it:
//!
//! ```text
//!     F = n · (d × u̇(d)) = 0        δd = δα n × d,     ∂F/∂α δα = −∂F/∂θ δθ at fixed d
//! ```
//!
//! for all such contacts together: F and α have an entry for each.

use crate::derivatives::equations::closed::{ClosedContacts, Friction, across};
use crate::derivatives::equations::residual::still;
use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::locating::Varying;
use crate::derivatives::events::walk::Walk;
use crate::derivatives::events::watched::Sight;
use crate::derivatives::forward::step::{Part, StepMode, WIDTH};
use crate::derivatives::forward::tangent::Tangent;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::events::trace::TracedStep;
use nalgebra::{DMatrix, DVector};
use std::cell::OnceCell;

impl Walk<'_> {
    /// Gives the directions of contacts that begin to slide from rest their derivatives.
    pub(super) fn turn_directions(&self, traced: &TracedStep, mode: &StepMode, closed: &mut [ClosedContacts<Part>]) {
        let begin = self.beginning(mode);
        if begin.is_empty() || begin.len() > WIDTH {
            return;
        }
        let (n, since) = (self.state.velocity.len(), self.state.time);
        let cell = OnceCell::new();
        let forces = |chunk: Option<usize>, tangent: &Tangent, closed: &ClosedContacts<Part>| {
            let varying = Varying { chunk, tangent, accelerations: &cell };
            let answer = |sight: &Sight| turning(sight, &begin);
            self.sighted(traced, mode, (&self.state, since), &varying, closed, None, answer)
        };
        let nothing =
            Tangent { positions: DMatrix::zeros(n, 1), velocities: DMatrix::zeros(n, 1), times: DVector::zeros(1) };
        let mut turned = mode.constant.clone();
        for (part, &touch) in begin.iter().enumerate() {
            let mut angle = Part::zero();
            angle.parts[part] = 1.0;
            self.turn(&mut turned, touch, angle);
        }
        let Some(by_angle) = forces(None, &nothing, &turned) else { return };
        let count = begin.len();
        let matrix = DMatrix::from_fn(count, count, |row, column| by_angle[row].parts[column]).lu();
        for (chunk, closed) in closed.iter_mut().enumerate() {
            let Some(by) = forces(Some(chunk), &self.tangent, closed) else { return };
            let right = DMatrix::from_fn(count, WIDTH, |row, part| -by[row].parts[part]);
            let Some(angles) = matrix.solve(&right) else { return };
            for (row, &touch) in begin.iter().enumerate() {
                let mut angle = Part::zero();
                (0..WIDTH).for_each(|part| angle.parts[part] = angles[(row, part)]);
                self.turn(closed, touch, angle);
            }
        }
    }

    /// The touches that begin to slide from rest with friction, by number.
    fn beginning(&self, mode: &StepMode) -> Vec<usize> {
        if mode.constant.touches.is_empty() {
            return Vec::new();
        }
        let offsets = vec![Part::zero(); self.state.velocity.len()];
        let at = Instant { figures: &self.constant, state: &self.state, offsets: &offsets, closed: &mode.constant };
        let velocities: Vec<Part> = self.state.velocity.iter().map(|&rate| Part::of(rate)).collect();
        let moves = at.placed(&velocities);
        let bodies = still(&moves);
        let begins = |touch: &usize| {
            let closed = &mode.constant.touches[*touch];
            let Friction::Slides { coefficient, direction } = closed.friction else { return false };
            let found = closed.touch.at(&bodies);
            let slip = across(found.normal, closed.touch.slip(&moves, found.point));
            coefficient.value > 0.0 && direction.dot(direction).value > 0.25 && closed.rests(&moves, &found, slip)
        };
        (0..mode.constant.touches.len()).filter(begins).collect()
    }

    /// Turns the direction of a touch about its normal by an angle without value.
    fn turn(&self, closed: &mut ClosedContacts<Part>, touch: usize, angle: Part) {
        let (offsets, none) = (vec![Part::zero(); self.state.velocity.len()], ClosedContacts::default());
        let at = Instant { figures: &self.constant, state: &self.state, offsets: &offsets, closed: &none };
        let own = &mut closed.touches[touch];
        let normal = own.touch.at(&at.at_rest()).normal.map(|entry| Part::of(entry.value));
        if let Friction::Slides { direction, .. } = &mut own.friction {
            let constant: Vector<Part> = direction.map(|entry| Part::of(entry.value));
            *direction = constant + normal.cross(constant).scaled(angle);
        }
    }
}

/// F of some touches.
fn turning(sight: &Sight, touches: &[usize]) -> Option<Vec<Part>> {
    let (accelerations, _) = sight.accelerations()?;
    let placed = sight.at.accelerated(sight.velocities, &accelerations);
    let of = |&touch: &usize| {
        let closed = &sight.at.closed.touches[touch];
        let Friction::Slides { direction, .. } = closed.friction else { return None };
        let found = closed.touch.with_rates().at(&placed);
        let normal = found.normal.map(|entry| entry.value);
        let change = closed.slip_change(&placed, &found);
        Some(normal.dot(across(normal, direction).cross(change)))
    };
    touches.iter().map(of).collect()
}

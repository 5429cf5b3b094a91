//! Closed contacts along a run: their equations in a mode with their derivatives, and the entry into the mode.
//!
//! ```text
//!     entry    G (v + δ) = 0,   H δ = Gᵀ π             also for the derivatives: a slip that has stopped has none
//!              φ(q + ε) = 0,    H ε = Gᵀ π             the derivatives of places, for parameters that would open or press a contact: valid within 0
//! ```
//!
//! H: mass matrix, G: gradients of all closures.

use crate::derivatives::equations::closed::{ClosedContacts, ClosedTouch, Friction, across};
use crate::derivatives::equations::figures::{End, LoopFigures, frame};
use crate::derivatives::equations::laws::Laws;
use crate::derivatives::equations::placed::end_frame;
use crate::derivatives::equations::residual::still;
use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::validity::MetEvent;
use crate::derivatives::events::walk::{AT_TICK, Walk};
use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::forward::stage_equations::BothFigures;
use crate::derivatives::forward::step::{Part, StepMode, WIDTH, lifted};
use crate::derivatives::forward::tangent::with;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::events::trace::{Closed, TracedStep, Watched};
use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use nalgebra::{DMatrix, DVector, Vector3};

/// Gaps and rates of contacts whose derivatives are this small have none (m, and m/s, per unit).
pub(super) const STAYS: f64 = 1e-8;
/// A slip below this is zero [m/s].
const NO_SPEED: f64 = 1e-12;
/// A slip that turns by less than this in a step is straight (rad): roundings and tolerances are smaller.
const STRAIGHT: f64 = 1e-6;

impl Walk<'_> {
    /// The corners that stick in a step.
    pub(super) fn anchors_of(&self, traced: &TracedStep) -> Vec<LoopFigures<f64>> {
        let end = |at: &Attachment| {
            let own = at.body.map_or_else(Pose::identity, |body| self.subject.frames[body].inverse());
            End { body: at.body, frame: frame(&(own * at.frame), &mut |value| value) }
        };
        let anchors = traced.closures.anchors.iter();
        anchors.map(|joint| LoopFigures { kind: joint.kind, a: end(&joint.a), b: end(&joint.b), length: 0.0 }).collect()
    }

    /// The other closed contacts of a step, with the numbers of their colliders and pairs.
    ///
    /// # Errors
    /// [`SensitivityError::Closed`] for features that have no equations here.
    pub(super) fn touches_of<T: Number>(
        &self,
        traced: &TracedStep,
        laws: &Laws<T>,
    ) -> Result<Vec<ClosedTouch<T>>, SensitivityError> {
        let closed = traced.mode.contacts.iter().filter(|closed| !traced.mode.is_anchored(closed));
        let touch = |closed: &Closed| {
            let touch = self.touch(&closed.contact, laws).ok_or_else(|| self.lost(closed))?;
            let friction = match closed.slides {
                Some(direction) => {
                    let direction = Vector::of(&direction);
                    Friction::Slides { coefficient: laws.pairs[closed.contact.pair].friction, direction }
                }
                None => Friction::Rolls,
            };
            Ok(ClosedTouch { touch, friction })
        };
        closed.map(touch).collect()
    }

    fn lost(&self, closed: &Closed) -> SensitivityError {
        SensitivityError::Closed { time: self.state.time, contact: self.names("and", closed.contact.pair) }
    }

    /// The directions of the slips of all closed contacts where the state is now, and the given ones of contacts that do not slip.
    pub(super) fn slips_of(&self, traced: &TracedStep) -> Vec<Vector3<f64>> {
        let bodies = body_states(self.subject.mechanism, &self.state);
        let of = |closed: &Closed| {
            let slip = touch_motion(&closed.contact.joint, &bodies).slip;
            let given = closed.slides.unwrap_or_default();
            if slip.norm() > NO_SPEED { slip.normalize() } else { given }
        };
        traced.mode.contacts.iter().map(of).collect()
    }

    /// Tells of slips that turn while they stop: of the contact itself `φ = u · t₀` is zero and u is not, and the slips of all others turn from the
    /// start of the step to its last inner stage.
    pub(super) fn see_turn(
        &mut self,
        traced: &TracedStep,
        trigger: Watched,
        [start, inside]: [&State; 2],
        words: &str,
    ) {
        let belongs = |contact: usize, closed: &Closed| match trigger {
            Watched::Slips(own) => own == contact,
            Watched::SlipsTogether(pair) => closed.contact.pair == pair && closed.slides.is_some(),
            _ => false,
        };
        let mechanism = self.subject.mechanism;
        let [before, after] = [start, &self.state].map(|state| body_states(mechanism, state));
        let of = |(contact, closed): (usize, &Closed)| {
            let [before, after] =
                [&before, &after].map(|bodies| touch_motion(&closed.contact.joint, bodies).slip.norm());
            belongs(contact, closed).then(|| after.atan2(before))
        };
        let own = traced
            .mode
            .contacts
            .iter()
            .enumerate()
            .filter_map(of)
            .fold(None, |most: Option<f64>, turned| Some(most.map_or(turned, |most| most.max(turned))));
        let Some(own) = own else { return };
        let [first, last] = [start, inside].map(|state| body_states(mechanism, state));
        let turns = |closed: &Closed| {
            let [one, other] = [&first, &last].map(|bodies| touch_motion(&closed.contact.joint, bodies).slip);
            one.cross(&other).norm().atan2(one.dot(&other))
        };
        let sliding = traced.mode.contacts.iter().filter(|closed| closed.slides.is_some());
        let turned = sliding.map(turns).fold(own, f64::max);
        if turned > STRAIGHT {
            let time = self.state.time;
            self.warnings.push(format!(
                "{words} at {time:.6} s: its slip turns by {turned:.1e} rad in the step that stops it, so that derivatives behind it have low order; \
                 halve the step and compare"
            ));
        }
    }

    /// The closed contacts of a mode with their derivatives, for each [`WIDTH`] parameters: new anchors are where their corners are now.
    pub(super) fn closed(
        &mut self,
        traced: &TracedStep,
        mode: &StepMode,
    ) -> Result<Vec<ClosedContacts<Part>>, SensitivityError> {
        let n = self.state.velocity.len();
        self.anchored.retain(|(known, _)| mode.closed.anchors.iter().any(|anchor| same(anchor, known)));
        let corners = traced.mode.contacts.iter().filter(|closed| traced.mode.is_anchored(closed));
        for (anchor, corner) in mode.closed.anchors.iter().zip(corners) {
            if self.anchored.iter().any(|(known, _)| same(anchor, known)) {
                continue;
            }
            let none = ClosedContacts::default();
            let varied = self.varied.chunks().iter().enumerate().map(|(chunk, figures)| {
                let offsets: Vec<Part> =
                    (0..n).map(|row| with(0.0, &self.tangent.positions, row, chunk * WIDTH)).collect();
                let at = Instant { figures, state: &self.state, offsets: &offsets, closed: &none };
                let placed = at.at_rest();
                let mut joint: LoopFigures<Part> = lifted(anchor);
                // The corner moves on its body with the sizes and the place of its collider.
                let moves = self.touch(&corner.contact, &figures.laws).ok_or_else(|| self.lost(corner))?.b.frame.origin;
                joint.b.frame.origin = joint.b.frame.origin + moves - moves.map(|entry| Part::of(entry.value));
                let corner = end_frame(&joint.b, &placed).origin;
                joint.a.frame.origin = match joint.a.body {
                    None => corner,
                    Some(body) => {
                        let frame = &placed[body].frame;
                        frame.axes.transpose().apply(corner - frame.origin)
                    }
                };
                Ok(joint)
            });
            let varied = varied.collect::<Result<_, SensitivityError>>()?;
            self.anchored.push((anchor.clone(), varied));
        }
        let of = |(chunk, figures): (usize, &BothFigures<Part>)| {
            let anchors = self.anchored.iter().map(|(_, varied)| varied[chunk].clone()).collect();
            let shares = mode.closed.shares.clone();
            Ok(ClosedContacts { anchors, touches: self.touches_of(traced, &figures.laws)?, shares })
        };
        self.varied.chunks().iter().enumerate().map(of).collect()
    }

    /// Enters a mode with closed contacts: places and velocities, and their derivatives, satisfy its equations.
    pub(super) fn enter(
        &mut self,
        traced: &TracedStep,
        mode: &StepMode,
        closed: &[ClosedContacts<Part>],
    ) -> Result<(), SensitivityError> {
        let is_like = |known: &[Closed]| {
            let of = |closed: &Closed| (closed.contact.pair, closed.contact.features, closed.slides.is_some());
            known.iter().map(of).eq(traced.mode.contacts.iter().map(of))
        };
        if is_like(&self.entered) {
            return Ok(());
        }
        self.see_unmet(traced);
        if self.state.time == self.began {
            self.see_opening(traced);
        }
        self.entered = traced.mode.contacts.clone();
        if mode.rows.is_empty() {
            return Ok(());
        }
        let (free, rows) = (mode.free.len(), mode.rows.len());
        let whole = self.gradient(mode).select_rows(&mode.rows).select_columns(&mode.free);
        let mass = self.mass(mode);
        let mut matrix = DMatrix::zeros(free + rows, free + rows);
        matrix.view_mut((0, 0), (free, free)).copy_from(&mass);
        matrix.view_mut((free, 0), (rows, free)).copy_from(&whole);
        matrix.view_mut((0, free), (free, rows)).copy_from(&whole.transpose());
        let factors = matrix.lu();
        let solve = |right: DMatrix<f64>| {
            let mut all = DMatrix::zeros(free + rows, right.ncols());
            all.view_mut((free, 0), right.shape()).copy_from(&right);
            factors.solve(&all)
        };
        let n = self.state.velocity.len();
        let p = self.tangent.times.len();
        let time = self.state.time;
        let failed = || SensitivityError::Step { time };
        for (chunk, (closed, figures)) in closed.iter().zip(self.varied.chunks()).enumerate() {
            let first = chunk * WIDTH;
            let width = WIDTH.min(p - first);
            let offsets: Vec<Part> = (0..n).map(|row| with(0.0, &self.tangent.positions, row, first)).collect();
            let at = Instant { figures, state: &self.state, offsets: &offsets, closed };
            let gaps = at.gaps();
            let right = DMatrix::from_fn(rows, width, |row, part| -gaps[mode.rows[row]].parts[part]);
            for (column, off) in right.column_iter().enumerate().filter(|(_, off)| off.amax() > STAYS) {
                self.validity.none(first + column, &opens(time, off.amax()));
            }
            let moved = solve(right).ok_or_else(failed)?;
            for (row, &freedom) in mode.free.iter().enumerate() {
                (0..width).for_each(|part| self.tangent.positions[(freedom, first + part)] += moved[(row, part)]);
            }
            let offsets: Vec<Part> = (0..n).map(|row| with(0.0, &self.tangent.positions, row, first)).collect();
            let velocities: Vec<Part> =
                (0..n).map(|row| with(self.state.velocity[row], &self.tangent.velocities, row, first)).collect();
            let at = Instant { figures, state: &self.state, offsets: &offsets, closed };
            let rates = at.closure_rates(&velocities);
            for off in self.lost_motions(traced, &at, &velocities) {
                for part in (0..width).filter(|&part| off.parts[part].abs() > STAYS) {
                    let what = format!("a closed contact parts or slips at {:.6} s", self.state.time);
                    if self.state.time > self.began && !self.warnings.iter().any(|known| known.starts_with(&what)) {
                        self.warnings.push(format!(
                            "{what}: the derivatives of the impact there do not keep it, and are wrong behind it"
                        ));
                    }
                    self.validity.none(first + part, &what);
                }
            }
            let right = DMatrix::from_fn(rows, width, |row, part| -rates[mode.rows[row]].parts[part]);
            let moved = solve(right).ok_or_else(failed)?;
            for (row, &freedom) in mode.free.iter().enumerate() {
                (0..width).for_each(|part| self.tangent.velocities[(freedom, first + part)] += moved[(row, part)]);
            }
        }
        let still = vec![Part::zero(); n];
        let at = Instant { figures: &self.constant, state: &self.state, offsets: &still, closed: &mode.constant };
        let velocities: Vec<Part> = self.state.velocity.iter().map(|&rate| Part::of(rate)).collect();
        let off = at.closure_rates(&velocities);
        let right = DMatrix::from_fn(rows, 1, |row, _| -off[mode.rows[row]].value);
        let moved = solve(right).ok_or_else(failed)?;
        mode.free.iter().enumerate().for_each(|(row, &freedom)| self.state.velocity[freedom] += moved[(row, 0)]);
        Ok(())
    }

    /// Tells of contacts that are closed from the start on, and open or are pressed with a parameter: corners that stick have no equations of their
    /// gaps, nor has a body that cannot move.
    fn see_opening(&mut self, traced: &TracedStep) {
        let time = self.state.time;
        for (chunk, figures) in self.varied.chunks().iter().enumerate() {
            let first = chunk * WIDTH;
            let rows = 0..self.state.velocity.len();
            let offsets: Vec<Part> = rows.map(|row| with(0.0, &self.tangent.positions, row, first)).collect();
            let at = Instant { figures, state: &self.state, offsets: &offsets, closed: &ClosedContacts::default() };
            let placed = at.at_rest();
            let touches = traced.mode.contacts.iter().filter_map(|closed| self.touch(&closed.contact, &figures.laws));
            let gaps: Vec<Part> = touches.map(|touch| touch.at(&placed).gap).collect();
            for gap in gaps {
                for (column, off) in
                    (first..self.tangent.times.len()).zip(gap.parts).filter(|(_, off)| off.abs() > STAYS)
                {
                    self.validity.none(column, &opens(time, off.abs()));
                }
            }
        }
    }

    /// Tells of closed contacts that change without an event, whose time would move.
    fn see_unmet(&mut self, traced: &TracedStep) {
        let time = self.state.time;
        let here = |event: &MetEvent| (event.time - time).abs() <= AT_TICK * time.abs().max(1.0);
        let first = self.entered.is_empty() || traced.mode.contacts.is_empty();
        if time > self.began && !first && !self.events.iter().rev().any(here) {
            self.warnings.push(format!(
                "closed contacts change at {time:.6} s without an event of their own: derivatives behind it leave out that its time moves; \
                 take another step or tolerance and compare"
            ));
        }
    }

    /// The velocities that closed contacts take away where their mode begins. At the start of a run any slip of contacts that stick counts; later it
    /// has stopped, and its derivatives with it.
    fn lost_motions(&self, traced: &TracedStep, at: &Instant<Part>, velocities: &[Part]) -> Vec<Part> {
        let moves = at.placed(velocities);
        let bodies = still(&moves);
        let begins = self.state.time == self.began;
        let of = |closed: &Closed| {
            let Some(touch) = self.touch(&closed.contact, &at.figures.laws) else { return Vec::new() };
            let found = touch.at(&bodies);
            let slip = touch.slip(&moves, found.point);
            let mut own = vec![found.normal.dot(slip)];
            if begins && closed.slides.is_none() {
                own.extend(across(found.normal, slip).0);
            }
            own
        };
        traced.mode.contacts.iter().flat_map(of).collect()
    }

    /// H along the freedoms that move.
    fn mass(&self, mode: &StepMode) -> DMatrix<f64> {
        let n = self.state.velocity.len();
        let still = vec![Part::zero(); n];
        let none = ClosedContacts::default();
        let at = Instant { figures: &self.constant, state: &self.state, offsets: &still, closed: &none };
        let column = |&freedom: &usize| {
            let mut unit = still.clone();
            unit[freedom] = Part::of(1.0);
            let momenta = at.momenta(&unit);
            DVector::from_iterator(mode.free.len(), mode.free.iter().map(|&row| momenta[row].value))
        };
        let columns: Vec<DVector<f64>> = mode.free.iter().map(column).collect();
        DMatrix::from_columns(&columns)
    }
}

/// Whether two anchors are the same one.
fn same(one: &LoopFigures<f64>, other: &LoopFigures<f64>) -> bool {
    let ends = |joint: &LoopFigures<f64>| [joint.a.body, joint.b.body];
    ends(one) == ends(other) && one.a.frame == other.a.frame && one.b.frame == other.b.frame
}

/// What is said of a closed contact whose gap has this derivative (m per unit).
fn opens(time: f64, off: f64) -> String {
    format!("a closed contact opens or is pressed at {time:.6} s, off by {off:.1e}")
}

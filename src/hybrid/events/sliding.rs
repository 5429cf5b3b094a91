//! Steps in which contacts slide: they end soon after the first of them stops, and are shorter where a long one cannot be solved.
//!
//! ```text
//!     t_stop = |u_T| / (−u̇_T · t)       u̇_T = D λ + b, with the forces of the mode where the step begins
//! ```
//!
//! Turnings that rolling and spinning friction brakes are slips at the arm of their pair.
//!
//! After the instant at which it stops, a slip has no direction, and the equations of the stages may have no solution.

use crate::events::finding::watched::Watched;
use crate::events::forces::closed_forces::{Slipping, What, slipping};
use crate::events::integrator::{Eventful, InUse};
use crate::events::modes::mode::Closed;
use crate::events::modes::tolerances::{BRIEF_SLIP, SHORTEST, STOPPED_SLIP, direction_of_slip, slip_at_rest};
use crate::events::parts::jams::FIRST as JAM_STEP;
use crate::events::parts::model::HybridModel;
use crate::events::parts::trial::StepTrial;
use crate::instant::holding::moments::Turning;
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::contact::Moment;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use nalgebra::Vector3;

/// A step goes beyond the stop of a slip by this factor: there it is found, and further on the slip has no direction.
const BEYOND: f64 = 1.05;
/// A slip that stops within this time (s) ends the step before the stop, because its direction is undefined there. The step goes this part of the
/// way, and the remaining slip is there at its end.
const SOON: f64 = 1e-5;
const SHORT_OF: f64 = 0.98;
/// A step is no longer than this part of the time in which a slip turns by half a right angle: a slip that is slow turns faster than the polynomials
/// through the stages can follow.
const TURNS: f64 = 2.0;
/// A slip below this part of the largest speed is slow. It keeps its direction if the cosine of the angle to the direction before is larger than
/// this.
const SLOWED: f64 = 1e-3;
const ALIKE: f64 = 0.7;
/// A slip that turns aside by less than this part of how it falls stops.
const STRAIGHT: f64 = 0.1;
/// It is no shorter than this for it (s).
const SOONEST: f64 = 1e-8;
/// A step in which slips cannot be solved is shortened by this factor.
const SLOWER: f64 = 0.25;
/// A step in which contacts slide is no shorter than this (s) if it is made anew.
pub(super) const JAM: f64 = 1e-7;
/// Closed contacts overlap by no more at the end of a step (m).
const OVERLAP: f64 = 1e-12;

/// A step on closed contacts that would have to be shorter than this (s) fails, because roundings of gaps are forces as large as weights in it.
const NO_DIGITS: f64 = 1e-9;

/// So does a step without closed contacts that would have to be shorter than this (s): in a gimbal lock joints turn at 1e7 rad/s and more, and the energy
/// of the bodies is a rounding of theirs.
const TOO_QUICK: f64 = 1e-11;

/// How the first slip that stops bounds a step.
pub(super) struct Stopping {
    /// A time soon after its stop (s); infinite if none slows down.
    pub until: f64,
    /// The slip, by its number among the watched functions, if it is slow and its stop nearer than steps are long.
    pub slow: Option<usize>,
    /// Whether it falls straight to the stop, and hardly turns.
    pub straight: bool,
}

impl Eventful {
    /// An event that is nearer to the start of a step than this is there (s).
    pub(super) fn shortest(&self, since: f64) -> f64 {
        if self.mode.contacts.is_empty() { 1e-14 * since.abs().max(1.0) } else { SHORTEST }
    }

    /// How the first contact that slides and would stop bounds a step.
    pub(super) fn soon_after_stop(&mut self, inputs: Inputs, since: f64, state: &State) -> Stopping {
        if !self.slides() {
            return Stopping { until: f64::INFINITY, slow: None, straight: false };
        }
        let rest = slip_at_rest(self.memory.fastest);
        let InUse { present, response, efforts, unique } = self.in_use();
        let mut all = vec![0.0; efforts.len()];
        present.mode.efforts_at(present.elements, inputs, since, state, &mut all);
        let Slipping { first, turns } = slipping(&present, response, state, &all, unique);
        let stops = first.map_or(f64::INFINITY, |stop| stop.time());
        let straight = first.is_some_and(|stop| stop.across <= STRAIGHT * stop.falls);
        // One that turns may pass its stop.
        let most = if straight { BRIEF_SLIP } else { STOPPED_SLIP };
        let slow = first.filter(|stop| stops <= SHORTEST && stop.speed <= most * rest);
        let slow = slow.and_then(|stop| {
            let slip = match stop.what {
                What::Slips if unique => Watched::Slips(stop.contact),
                What::Slips => Watched::SlipsTogether(stop.pair),
                What::Rolls | What::Spins => Watched::Turns(stop.contact, stop.what == What::Spins),
            };
            self.trial.watched.iter().position(|known| *known == slip)
        });
        let stops = if stops < SOON { SHORT_OF * stops } else { BEYOND * stops };
        Stopping { until: since + stops.min(TURNS * turns).max(SOONEST), slow, straight }
    }

    /// Whether friction brakes any closed contact: it slides, or turns against a moment.
    pub(super) fn slides(&self) -> bool {
        self.mode.contacts.iter().any(Closed::is_braked)
    }

    /// A step is not made shorter than this (s) where it cannot be solved.
    fn gives_up(&self) -> f64 {
        match self.slides() {
            true => JAM_STEP,
            false if !self.mode.contacts.is_empty() => NO_DIGITS,
            false => TOO_QUICK,
        }
    }

    /// Whether a gimbal lock has made the last step shorter than its energy has digits for.
    fn is_too_quick(&self, since: f64, until: f64) -> bool {
        let length = self.workspaces.active().small.time - since;
        length < TOO_QUICK
            && until - since > TOO_QUICK
            && self.model.touching.pairs.is_empty()
            && self.starts_singular()
    }

    /// Makes the step; a shorter one where contacts are closed and a long one cannot be solved.
    pub(super) fn step_towards(&mut self, inputs: Inputs, since: f64, until: f64) -> Result<StepOutcome, StepError> {
        let closed = !self.mode.contacts.is_empty();
        let least = self.gives_up();
        if let Some(steps) = &mut self.workspaces.active_mut().steps {
            steps.give_up_below(least);
        }
        let mut until = until;
        loop {
            let piece = self.workspaces.active_mut();
            let made = piece.step(&self.model.whole, inputs, until);
            match made {
                Ok(outcome) if self.is_too_quick(since, until) => {
                    self.workspaces.active_mut().go_back(since, &self.model.recipe);
                    return Err(StepError::NotAccurate { time: since, step: outcome.step });
                }
                Ok(outcome) => return Ok(outcome),
                Err(StepError::NotConverged { .. } | StepError::NotAccurate { .. })
                    if closed && until - since > SOONEST.max(least) =>
                {
                    self.workspaces.active_mut().go_back(since, &self.model.recipe);
                    until = since + SLOWER * (until - since);
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Whether a closed contact overlaps at the end of the step by more than roundings: if sliding contacts nearly jam, the iteration of the stages
    /// converges slowly, and ends with the remaining residual.
    pub(super) fn overlaps(&mut self, end: &State) -> bool {
        if self.mode.contacts.is_empty() {
            return false;
        }
        let Eventful { model: HybridModel { whole, .. }, trial: StepTrial { bodies, placed, .. }, mode, .. } = self;
        placed.place(whole, end, bodies);
        mode.contacts.iter().any(|closed| touch_motion(&closed.contact.joint, bodies).gap < -OVERLAP)
    }

    /// Takes the directions in which closed contacts slide at the end of the step that was made last. Near a stop the component across a slip is the
    /// error of the step: a slow slip that would turn by more than half a right angle keeps its direction.
    pub(super) fn turn_slips(&mut self) {
        let Eventful { trial: StepTrial { bodies, slips, turns, .. }, model, mode, memory, .. } = self;
        let turn = |slip: Vector3<f64>, arm: f64, along: &mut Vector3<f64>| {
            let speed = slip.norm();
            if arm * speed > SLOWED * memory.fastest || slip.dot(along) > ALIKE * speed {
                *along = slip.try_normalize(0.0).unwrap_or(*along);
            }
        };
        for (closed, (along, turns)) in mode.contacts.iter().zip(slips.iter_mut().zip(turns)) {
            let Contact { pair, joint, .. } = &closed.contact;
            let motion = touch_motion(joint, bodies);
            turn(motion.slip, 1.0, along);
            if closed.moments.brake() {
                let turning = Turning::of(joint, bodies, &motion.normal);
                turn(turning.across, model.touching.pairs[*pair].arm(), &mut turns[0]);
            }
        }
    }

    /// The directions in which a closed contact turns where the bodies are placed, against its moments of friction.
    fn turning_now(&self, closed: &Closed) -> [Vector3<f64>; 2] {
        let Closed { contact: Contact { pair, joint, .. }, moments, .. } = closed;
        if !moments.brake() {
            return [Vector3::zeros(); 2];
        }
        let normal = touch_motion(joint, &self.trial.bodies).normal;
        let turning = Turning::of(joint, &self.trial.bodies, &normal);
        let rest = slip_at_rest(self.memory.fastest);
        let arm = self.model.touching.pairs[*pair].arm();
        let begins = |moment: Moment| match moment {
            Moment::Brakes { direction, .. } => direction,
            Moment::Free | Moment::Holds => Vector3::zeros(),
        };
        let now = |of: Vector3<f64>, begins: Vector3<f64>| {
            of.try_normalize(0.0).filter(|_| arm * of.norm() > rest).unwrap_or(begins)
        };
        [now(turning.across, begins(moments.rolling)), now(normal * turning.along, begins(moments.spinning))]
    }

    /// Takes the directions in which closed contacts slide in a state; those that begin to slide have the ones of the decision.
    pub(super) fn note_slips(&mut self, state: &State) {
        self.trial.slips.clear();
        self.trial.turns.clear();
        self.trial.begins.clear();
        if self.mode.contacts.is_empty() {
            return;
        }
        self.trial.placed.place(&self.model.whole, state, &mut self.trial.bodies);
        for closed in &self.mode.contacts {
            let begins = closed.slides.unwrap_or_default();
            let slip = touch_motion(&closed.contact.joint, &self.trial.bodies).slip;
            self.trial.slips.push(direction_of_slip(&slip, begins, slip_at_rest(self.memory.fastest)));
            self.trial.turns.push(self.turning_now(closed));
            self.trial.begins.push(slip);
        }
    }
}

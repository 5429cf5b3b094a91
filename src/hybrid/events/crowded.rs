//! A run in a crowd of events: when it begins, the length of its steps (`crowd/`), and when exact steps take over again.
//!
//! ```text
//!     h = tolerance/(κ v),  from 0.1 to 2 ms; 1 ms at least beyond the horizon                            v: largest speed so far [m/s]
//!     h = 0.1 ms, longer in crowds that follow each other (`parts/spells.rs`), where no such step keeps to the tolerance
//!     begins:   exact steps are too dear (`price.rs`), or the decision of the start of a run is
//!     ends:     calm, and exact steps are expected to cost less than half
//! ```
//!
//! A step that cannot be made is tried with a quarter of its length. A crowd ends by it only after the last try. A step whose residual is above 1e-4 is
//! made once more, with a quarter of its length, and the one with the smaller residual is taken.

use crate::crowd::newton::Interrupt;
use crate::events::crowd::contacts::{Scene, has_row};
use crate::events::crowd::step::Made;
use crate::events::integrator::Eventful;
use crate::events::modes::mode::MotorMode;
use crate::events::parts::jams::Jams;
use crate::events::parts::model::HybridModel;
use crate::events::parts::progress::Progress;
use crate::events::parts::spells::Spells;
use crate::events::parts::spending::Spending;
use crate::events::parts::workspaces::Workspaces;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::StepOutcome;
use crate::mechanism::motion::state::State;

/// Lengths of steps (s): the least, the most, and the most of those that do not keep to the tolerance.
pub(super) const LENGTHS: [f64; 2] = [1e-4, 2e-3];
const PLAIN: f64 = 1e-3;
/// κ: the error of an impact over its change of velocity and the length of the step.
const SMEARS: f64 = 0.3;
/// Bodies at rest may come to the speed of a fall for this time (s).
const FALLS: f64 = 0.1;
/// A step that would leave less than this part of its length goes to the end: gaps are velocities of any size in a step of roundings of the time.
const SLIVER: f64 = 1e-6;
/// A step with a larger residual is made once more, shorter.
const UNSOLVED: f64 = 1e-4;
/// A step is made shorter by this factor, this often at most.
const SHORTER: f64 = 0.25;
const SHORTENED: usize = 4;

/// A step over events: its end, its length (s) and figures.
pub(super) struct Attempted {
    pub end: State,
    pub step: f64,
    pub made: Made,
}

/// What a run has seen of crowds, for one that goes on from it with other bodies.
#[derive(Clone, Copy)]
pub struct CrowdsSoFar {
    spending: Spending,
    spells: Spells,
    jams: Jams,
    in_crowd: bool,
    beyond_horizon: bool,
    /// The largest speed of its bodies, in the mean over their masses [m/s].
    speed: f64,
}

impl CrowdsSoFar {
    /// What two runs have seen that are one from now on.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let (speed, beyond_horizon) = (self.speed.max(other.speed), self.beyond_horizon || other.beyond_horizon);
        let base = if other.in_crowd && !self.in_crowd { other } else { self };
        CrowdsSoFar { speed, beyond_horizon, ..base }
    }
}

impl Eventful {
    /// What it has seen of crowds.
    pub fn crowds_so_far(&self) -> CrowdsSoFar {
        let speed = self.fastest();
        let &Progress { spending, spells, jams, in_crowd, beyond_horizon, .. } = &self.progress;
        CrowdsSoFar { spending, spells, jams, in_crowd, beyond_horizon, speed }
    }

    /// Goes on from what another run has seen, before the first step: in a crowd if that was in one.
    pub fn go_on_from(&mut self, before: CrowdsSoFar) {
        self.progress.spending = before.spending;
        (self.progress.spells, self.progress.jams) = (before.spells, before.jams);
        self.progress.goes_on_in_crowd = before.in_crowd;
        self.progress.beyond_horizon |= before.beyond_horizon;
        self.memory.kinetic = 0.5 * self.mass() * before.speed.powi(2);
    }

    fn mass(&self) -> f64 {
        self.model.whole.bodies.iter().map(|body| body.mass).sum()
    }

    /// The largest speed of its bodies so far, in the mean over their masses [m/s].
    fn fastest(&self) -> f64 {
        let speed = (2.0 * self.memory.kinetic / self.mass()).sqrt();
        if speed.is_finite() { speed } else { 0.0 }
    }

    /// The length of steps over events (s), and whether they keep to the tolerance, which asks for nothing beyond the horizon.
    pub(super) fn crowd_length(&self) -> (f64, bool) {
        if let Some(length) = self.model.over_events {
            return (length, true);
        }
        let speed = self.fastest().max(FALLS * self.model.whole.gravity.norm());
        let kept = self.model.recipe.tolerance().filter(|_| speed > 0.0).map(|tolerance| tolerance / (SMEARS * speed));
        match kept {
            Some(length) if length >= LENGTHS[0] => {
                let least = if self.progress.beyond_horizon { PLAIN } else { LENGTHS[0] };
                (length.clamp(least, LENGTHS[1]), true)
            }
            // Joints that hard dampers hold hardly move.
            Some(_) if self.progress.chatters => (LENGTHS[0], true),
            _ if self.progress.beyond_horizon => (PLAIN, true),
            _ => (self.length_in_spells(), false),
        }
    }

    /// The length of steps that do not keep to the tolerance (s): longer in crowds that follow each other.
    pub(super) fn length_in_spells(&self) -> f64 {
        (LENGTHS[0] * self.progress.spells.longer()).min(PLAIN)
    }

    /// Once this flag is set, a step over events that is being made is given up: then a step has no length, and leaves the state as it is.
    pub fn heed_interrupt(&mut self, interrupt: Interrupt) {
        if let Some(crowd) = &mut self.workspaces.crowd {
            crowd.heed(interrupt);
        }
    }

    /// Whether that flag is set, in a run that may step over events.
    pub(super) fn is_interrupted(&self) -> bool {
        self.workspaces.crowd.as_ref().is_some_and(|crowd| crowd.is_interrupted())
    }

    /// The error of the run is estimated: up to its horizon given instants alone are no reason for steps over events.
    pub fn keep_estimate(&mut self) {
        self.progress.estimated = true;
    }

    /// From now on no step can be accurate: runs that differ by roundings have met other events.
    pub fn pass_horizon(&mut self) {
        self.progress.beyond_horizon = true;
    }

    /// Whether steps over events leave something out: rolling and spinning friction, and ropes through several points.
    pub(super) fn needs_events(&self) -> bool {
        self.model.touching.pairs.need_events()
    }

    /// Begins a run in a crowd, if all steps are over events or the decision of its start costs more than those; `false` otherwise.
    pub(super) fn begin_in_crowd(&mut self, state: &State) -> bool {
        if self.model.over_events.is_some() {
            self.progress.spells.enter(state.time);
            self.progress.in_crowd = true;
            return true;
        }
        let (length, _) = self.crowd_length();
        let HybridModel { whole, elements, touching, recipe, .. } = &self.model;
        if touching.pairs.is_empty() || recipe.keeps(Rule::Crowds) || self.needs_events() {
            return false;
        }
        if std::mem::take(&mut self.progress.goes_on_in_crowd) && self.workspaces.crowd.is_some() {
            self.progress.in_crowd = true;
            return true;
        }
        let scene = Scene { whole, elements, touching };
        let held = self.workspaces.crowd.as_mut().and_then(|crowd| crowd.held_at(scene, state, length));
        if !self.is_start_too_dear(held.unwrap_or(0)) {
            return false;
        }
        self.workspaces.leave_companion();
        self.progress.asleep = false;
        self.progress.spells.enter(state.time);
        self.progress.in_crowd = true;
        true
    }

    /// Begins a crowd with a step from a state towards `until`; `None` if a step that jams is to be passed by a shorter and plastic one that is stable, if
    /// crowds are switched off, or if the step cannot be made.
    pub(super) fn enter_crowd(&mut self, inputs: Inputs, state: &mut State, until: f64) -> Option<StepOutcome> {
        let (length, _) = self.crowd_length();
        if self.model.recipe.keeps(Rule::Crowds) || self.needs_events() {
            return None;
        }
        let spells = self.progress.spells;
        let jam = self.progress.jams.next();
        if jam.is_some_and(|length| !self.overshoots(state, length)) {
            return None;
        }
        self.progress.spells.enter(state.time);
        let Some((mut outcome, made)) = self.step_in_crowd(inputs, state, until, self.model.coarser * length) else {
            self.progress.spells = spells;
            return None;
        };
        self.progress.in_crowd = true;
        if self.is_over(&made, length) {
            self.leave_crowd(inputs, state, &mut outcome);
        }
        Some(outcome)
    }

    /// The next step of a crowd from a state that the last one has left; `None` if the run is in no crowd, or the step cannot be made.
    pub(super) fn go_on_in_crowd(&mut self, inputs: Inputs, state: &mut State, until: f64) -> Option<StepOutcome> {
        if !self.progress.in_crowd {
            return None;
        }
        let next = self.model.next_instant(state.time, until);
        let (length, _) = self.crowd_length();
        let made = if self.progress.is_careful {
            self.step_carefully(inputs, state, next)
        } else {
            self.step_in_crowd(inputs, state, next, self.model.coarser * length)
        };
        let Some((mut outcome, made)) = made else {
            if self.is_interrupted() {
                return None;
            }
            self.progress.in_crowd = false;
            self.progress.is_careful = false;
            self.pass_anew(inputs, state);
            return None;
        };
        if self.is_over(&made, length) {
            self.leave_crowd(inputs, state, &mut outcome);
        }
        match &mut self.previous.left {
            Some(left) => left.copy_from(state),
            none => *none = Some(state.clone()),
        }
        Some(outcome)
    }

    /// Whether a crowd is over after a step of this length (s): it is calm, and exact steps are cheaper.
    pub(super) fn is_over(&mut self, made: &Made, length: f64) -> bool {
        if self.model.over_events.is_some() {
            return false;
        }
        if self.progress.is_careful {
            return self.progress.spells.is_calm(made.closed);
        }
        self.progress.spells.is_calm(made.closed) && self.are_exact_steps_cheaper(length, made) && !made.asleep
    }

    /// The mode is decided anew at the end of a crowd; what that takes from the motion counts as lost in impacts.
    pub(super) fn leave_crowd(&mut self, inputs: Inputs, state: &mut State, outcome: &mut StepOutcome) {
        self.progress.in_crowd = false;
        self.progress.is_careful = false;
        self.progress.spells.leave(state.time);
        self.previous.outside.clear();
        self.previous.outside.extend_from_slice(inputs.efforts);
        for index in 0..self.model.elements.motors.len() {
            // A sampled motor holds its effort until its next tick, however steps are made.
            if !self.model.elements.motors[index].is_between_ticks(state.time) {
                self.mode.motors[index] = self.motor_mode(index, state);
            }
        }
        let events = self.tally.events.len();
        outcome.exchange += self.pass_anew(inputs, state);
        self.tally.events.truncate(events);
        self.progress.stepped_over = Some(state.clone());
        let piece = self.workspaces.active_mut();
        piece.small = piece.moving.gather(&self.model.whole, state);
    }

    /// Makes one step of at most this length (s) towards `until`, or a shorter one, if any can be made.
    fn step_in_crowd(
        &mut self,
        inputs: Inputs,
        state: &mut State,
        until: f64,
        length: f64,
    ) -> Option<(StepOutcome, Made)> {
        let length = length.min(until - state.time);
        let shorter = |times: usize| length * SHORTER.powi(times as i32);
        let mut attempts = (0..=SHORTENED).map(shorter);
        let mut next = |own: &mut Self| attempts.find_map(|length| own.attempt_in_crowd(inputs, state, until, length));
        let mut attempted = next(self)?;
        if attempted.made.residual > UNSOLVED {
            // Fewer contacts close in a shorter step.
            let crowd = self.workspaces.crowd.clone();
            match next(self).filter(|again| again.made.residual < attempted.made.residual) {
                Some(again) => attempted = again,
                None => self.workspaces.crowd = crowd,
            }
        }
        Some(self.take_from_crowd(state, &attempted))
    }

    /// Makes a step of at most this length (s) from a state; the run does not go on from its end until it is taken.
    pub(super) fn attempt_in_crowd(
        &mut self,
        inputs: Inputs,
        state: &State,
        until: f64,
        length: f64,
    ) -> Option<Attempted> {
        self.trial.origin.copy_from(state);
        let Eventful {
            model: HybridModel { whole, elements, touching, recipe, .. },
            workspaces: Workspaces { response, crowd, .. },
            mode,
            progress,
            ..
        } = self;
        let crowd = crowd.as_mut().filter(|crowd| !crowd.is_interrupted())?;
        if recipe.keeps(Rule::Sleep) || progress.is_careful {
            crowd.keep_awake();
        }
        let mut forces = |at: &State, accelerations: &mut [f64], efforts: &mut [f64]| {
            inputs.write_constant(efforts);
            inputs.add_feedback(at, efforts);
            for (motor, mode) in elements.motors.iter().zip(&mode.motors).filter(|(motor, _)| !has_row(motor)) {
                let place = motor.coordinate;
                efforts[place.freedom] += match *mode {
                    MotorMode::Given(effort) => effort,
                    _ => {
                        let position = at.position[place.position] + at.compensation[place.position];
                        motor.effort(at.time, position, at.velocity[place.freedom])
                    }
                };
            }
            response.accelerations(at, efforts, accelerations);
        };
        let scene = Scene { whole, elements, touching };
        let constant = elements.motors.iter().all(|motor| motor.target.is_constant()) && !whole.changes();
        let evenly = inputs.feedback.is_none() && constant;
        let rest = until - state.time;
        let asleep = evenly && crowd.sleeps(state, &mut forces);
        let step = if asleep || rest < (1.0 + SLIVER) * length { rest } else { length };
        let mut end = state.clone();
        let made = crowd.step(scene, &mut forces, &mut end, step, evenly)?;
        // The end is a given instant to the last bit.
        end.time = if step == rest { until } else { end.time };
        Some(Attempted { end, step, made })
    }

    /// Takes such a step from the origin of the trial.
    pub(super) fn take_from_crowd(&mut self, state: &mut State, attempted: &Attempted) -> (StepOutcome, Made) {
        let &Attempted { ref end, step, made } = attempted;
        state.copy_from(end);
        for index in 0..self.model.elements.motors.len() {
            let motor = &self.model.elements.motors[index];
            if motor.ticks(self.trial.origin.time, state.time) {
                self.mode.motors[index] = self.motor_mode(index, state);
            }
        }
        let Made { iterations, residual, unsolved, overlap, lifted, work, dissipated, friction, lost, slept, .. } =
            made;
        self.tally.unsolved += unsolved;
        self.trial.overlap = self.trial.overlap.max(overlap);
        self.tally.crowd_figures = (self.tally.crowd_figures.0.max(residual), self.tally.crowd_figures.1.max(lifted));
        let kind = if self.progress.is_careful { &mut self.tally.over_slips } else { &mut self.tally.first_order };
        *kind = (kind.0 + 1, kind.1 + step);
        self.tally.asleep += slept * step;
        // Nothing moves in a step in which all sleep.
        self.tally.smeared[0] += if slept < 1.0 { step * step } else { 0.0 };
        // An impact within the step is at its end for samples inside it.
        self.workspaces.earlier.see_between(Some(0.25 * step * made.jump + lifted));
        self.progress.stepped_over = Some(state.clone());
        self.memory.kinetic = self.memory.kinetic.max(made.kinetic);
        self.tally.steps += 1;
        self.tally.stepped += step;
        let impacts = lost - dissipated - friction;
        let exchange = Exchange { work, dissipated, friction, impacts };
        (StepOutcome::new(step, iterations, exchange), made)
    }

    /// Adds the contacts that press at the end of a step of a crowd, with their mean forces in it; `false` if the run is in no crowd.
    pub(super) fn report_crowd(&self, out: &mut Vec<ContactPoint>) -> bool {
        let Some(crowd) = self.workspaces.crowd.as_ref().filter(|_| self.progress.in_crowd) else { return false };
        crowd.pressing(&self.model.touching, out);
        true
    }
}

/// The least part of their mean length that steps over events may have.
pub fn least_part(mean: f64) -> f64 {
    LENGTHS[0] / mean
}

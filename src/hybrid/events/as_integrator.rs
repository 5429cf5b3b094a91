//! The steps of a run through its modes, as an integrator makes them: exact ones, and one of first order where these are too many or cannot be made.
//!
//! ```text
//!     other efforts ─▶ decided anew (changed_efforts.rs) ─▶ next_step.rs ─┬▶ advance (steps.rs) ─▶ an error ─▶ stumble (stepwise.rs)
//!                                                                         └▶ a crowd (crowded.rs) ─▶ stumble
//! ```

use crate::events::finding::detection::ONE_INSTANT;
use crate::events::integrator::Eventful;
use crate::events::modes::mode::{JointMode, MotorMode};
use crate::events::modes::piece::Piece;
use crate::events::next_step::NextStep;
use crate::events::parts::model::HybridModel;
use crate::events::parts::progress::Progress;
use crate::events::parts::trial::StepTrial;
use crate::events::parts::workspaces::Workspaces;
use crate::instant::holding::rope::is_rope;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::{Event, JointStatus};
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Cost, Integrator, MethodDescription, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::stepping::step_maker::{StepFigures, StepMaker, StepPace};

/// The longest step (s) while efforts that follow the state hold every joint, so that only time advances.
const LOOK: f64 = 1e-3;
/// Stages resolve motions and loads over time in steps of some length. Steps with watched functions are shorter by this factor, because a force that
/// follows a sine is negative for a part of its period.
const SAMPLED: f64 = 2.0;
/// The name of a method all of whose steps are over events.
const OVER_EVENTS: &str = "midpoint over events";

impl Eventful {
    /// The end of the longest step that stages resolve the targets of motors over (s), where steps are chosen, and the loads where nothing moves; no
    /// later than `until`.
    fn resolved_until(&self, time: f64, until: f64) -> f64 {
        let pace = self.workspaces.active().steps.as_ref().map(|steps| steps.step_pace(time));
        let step = match pace {
            Some(StepPace::Step { length, .. }) if length > 0.0 => length,
            Some(StepPace::Step { .. }) | None => until - time,
            Some(StepPace::Grid { .. }) => return until,
        };
        let resolved = self.model.resolved_step(time, step, until);
        // Where bodies move, stages resolve the loads; the samples of watched functions are fewer than the stages.
        let times = if pace.is_none() || self.mode.contacts.iter().all(|closed| is_rope(&closed.contact.joint)) {
            1.0
        } else {
            SAMPLED
        };
        // That a stretch of `times` the step is resolved is asked beyond the end of the run, too: else each step would be a part of what is left.
        let stretch = times * resolved;
        let resolved = resolved.min(self.model.whole.resolved_step(time, stretch, until.max(time + stretch)) / times);
        if resolved < step.min(until - time) { time + resolved } else { until }
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
        let moved = self.previous.left.as_ref().is_none_or(|left| left != state);
        if moved || self.model.is_other(mechanism) {
            self.begin(mechanism, inputs, state)?;
            self.is_blocked(state.time)?;
        }
        self.previous.motors.clone_from(&self.mode.motors);
        // A step over events that could not be made has left a crowd.
        if self.model.over_events.is_some() && !self.progress.in_crowd {
            self.begin_in_crowd(state);
        }
        if let Some(mut outcome) = self.go_on_in_crowd(inputs, state, until) {
            outcome.exchange += std::mem::take(&mut self.tally.lost_at_start);
            return Ok(outcome);
        }
        if self.progress.in_crowd {
            // It was interrupted.
            self.previous.left = None;
            return Ok(StepOutcome::default());
        }
        self.heed(inputs, state);
        self.follow_commands(inputs, state);
        let mut next = self.model.next_instant(state.time, until);
        if inputs.feedback.is_some() && self.workspaces.active().steps.is_none() {
            next = next.min(state.time + LOOK);
        }
        // Efforts of a program change at ticks, to which it asks for steps.
        self.progress.bounded = next < until || inputs.efforts.iter().any(|effort| *effort != 0.0);
        next = next.min(self.resolved_until(state.time, next));
        self.progress.stepped_over = None;
        let over_slips = if self.slips_are_dear(state.time) { self.begin_carefully(inputs, state, next) } else { None };
        let advanced = match over_slips {
            Some(outcome) => Ok(outcome),
            None => match self.next_step(state) {
                NextStep::FirstOrder => {
                    self.trial.origin.copy_from(state);
                    Ok(self.stumble(inputs, state, next))
                }
                smooth => self.advance(inputs, state, next, smooth),
            },
        };
        let mut outcome = match advanced {
            Err(
                StepError::NotConverged { .. }
                | StepError::NotAccurate { .. }
                | StepError::TurnedTooFar { .. }
                | StepError::Unstable { .. },
            ) if !self.model.touching.pairs.is_empty() => {
                state.copy_from(&self.trial.origin);
                let (since, slides) = (state.time, self.slides());
                let again = slides && self.progress.jams.come_again(since) && self.may_step_carefully(since);
                match if again { self.begin_carefully(inputs, state, next) } else { None } {
                    Some(outcome) => outcome,
                    None => {
                        self.jam(since);
                        self.stumble(inputs, state, next)
                    }
                }
            }
            Err(StepError::NotConverged { .. } | StepError::NotAccurate { .. } | StepError::TurnedTooFar { .. })
                if self.model.touching.pairs.is_empty() =>
            {
                self.jam(self.trial.origin.time);
                self.pass_singular(inputs, state, next)
            }
            // A given step was halved again and again, and is beyond the limit of stability because joints turn without bound, or because a loop with
            // held joints has no motion to follow.
            Err(StepError::Unstable { .. })
                if self.model.touching.pairs.is_empty() && (self.starts_singular() || self.holds_in_loops()) =>
            {
                self.jam(self.trial.origin.time);
                self.pass_singular(inputs, state, next)
            }
            done => done?,
        };
        self.is_blocked(state.time)?;
        outcome.cost.add(&std::mem::take(&mut self.tally.abandoned));
        outcome.exchange += std::mem::take(&mut self.tally.lost_at_start);
        // The remaining time is below the rounding of the time.
        if until - state.time < ONE_INSTANT * until.abs().max(1.0) && state.time != until {
            outcome.step += until - state.time;
            state.time = until;
            self.workspaces.active_mut().small.time = until;
        }
        if !self.model.touching.pairs.is_empty() {
            self.previous.felt.see(inputs, &self.trial.origin, state);
        }
        match &mut self.previous.left {
            Some(left) => left.copy_from(state),
            none => *none = Some(state.clone()),
        }
        Ok(outcome)
    }

    fn dense(&mut self, _mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let Eventful {
            model: HybridModel { whole, .. },
            workspaces: Workspaces { pieces, last, crowd, .. },
            trial: StepTrial { sample, origin, .. },
            progress: Progress { stepped_over, .. },
            ..
        } = self;
        sample.copy_from(origin);
        if let Some(end) = stepped_over {
            if let Some(inside) = crowd.as_ref().and_then(|crowd| crowd.inside(whole, origin, end, time)) {
                position.copy_from_slice(&inside.position);
                velocity.copy_from_slice(&inside.velocity);
                return;
            }
            let nearest = if time - origin.time < end.time - time { &*origin } else { &*end };
            position.copy_from_slice(&nearest.position);
            velocity.copy_from_slice(&nearest.velocity);
            return;
        }
        let piece = &mut *pieces[*last];
        let Piece { moving, steps, small_position, small_velocity, .. } = piece;
        if let Some(steps) = steps {
            steps.dense(&moving.mechanism, time, small_position, small_velocity);
            moving.spread_positions(whole, small_position, &mut sample.position);
            moving.spread_velocities(whole, small_velocity, &mut sample.velocity);
        }
        position.copy_from_slice(&sample.position);
        velocity.copy_from_slice(&sample.velocity);
    }

    fn take_abandoned(&mut self) -> Cost {
        std::mem::take(&mut self.tally.abandoned)
    }

    fn description(&self) -> MethodDescription {
        let steps = self.workspaces.pieces.get(self.workspaces.current).and_then(|piece| piece.steps.as_ref());
        let mut description = steps.map_or_else(|| self.workspaces.idle.clone(), |steps| steps.description());
        // The findings of other modes.
        description.include_stability(&self.workspaces.idle);
        description.few_stage_steps = self.workspaces.idle.few_stage_steps;
        for steps in self.workspaces.pieces.iter().filter_map(|piece| piece.steps.as_ref()) {
            let of_piece = steps.description();
            description.include_stability(&of_piece);
            description.few_stage_steps += of_piece.few_stage_steps;
        }
        if description.adaptive {
            description.step = self.tally.stepped / self.tally.steps.max(1) as f64;
        }
        if let Some(length) = self.model.over_events {
            description = MethodDescription::fixed(OVER_EVENTS, Eventful::STAGES_OVER_EVENTS, 1, length);
        }
        description.unsolved_contacts = self.tally.unsolved;
        description.contact_solvers = self.tally.solvers;
        (description.first_order_steps, description.first_order_time) = self.tally.first_order;
        (description.over_slips_steps, description.over_slips_time) = self.tally.over_slips;
        description.first_order_asleep = self.tally.asleep;
        (description.first_order_residual, description.first_order_lift) = self.tally.crowd_figures;
        (description.rebounds_left_out, description.rebounds_energy) = self.tally.cut;
        description
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        events.append(&mut self.tally.events);
    }

    fn contacts(&self, _mechanism: &Mechanism, state: &State, out: &mut Vec<ContactPoint>) {
        if !self.report_crowd(out) {
            self.report_contacts(state, out);
        }
    }

    fn held_efforts(&self, inside: bool, out: &mut Vec<Option<f64>>) {
        let modes = if inside { &self.previous.motors } else { &self.mode.motors };
        out.extend(modes.iter().map(|mode| match *mode {
            MotorMode::Given(effort) => Some(effort),
            MotorMode::Unbounded | MotorMode::Saturated(_) => None,
        }));
    }

    fn joint_status(&self, _mechanism: &Mechanism, state: &State, body: usize) -> JointStatus {
        let mut status = JointStatus::default();
        for (joint, mode) in self.model.elements.joints.iter().zip(&self.mode.joints) {
            let held = match *mode {
                JointMode::Held { on } if !self.progress.in_crowd => Some(on),
                _ => None,
            };
            status = joint.status(body, held).unwrap_or(status);
        }
        for (motor, mode) in self.model.elements.motors.iter().zip(&self.mode.motors) {
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

impl StepMaker for Eventful {
    fn figures(&self) -> StepFigures {
        self.workspaces.figures()
    }

    /// Up to the first event, without closed loops, and without motors that are sampled: their efforts would be those of the run in both motions.
    fn accompany(&mut self, mechanism: &Mechanism) -> bool {
        self.workspaces.accompanied = !mechanism.has_closures() && !mechanism.nonsmooth.samples();
        self.workspaces.accompanied
    }

    fn leave_companion(&mut self) {
        self.workspaces.leave_companion();
    }

    fn place_companion(&self, state: &mut State) -> bool {
        let Workspaces { pieces, current, accompanied, .. } = &self.workspaces;
        let Some(piece) = pieces.get(*current).filter(|_| *accompanied) else { return false };
        let mut small = piece.small.clone();
        let is_placed = piece.steps.as_ref().is_some_and(|steps| steps.place_companion(&mut small));
        if is_placed {
            piece.moving.spread(&self.model.whole, &small, state);
        }
        is_placed
    }
}

//! The integrator of motions that are smooth in pieces: steps of the scheme for the reduced mechanism of a mode, ended at events.

use crate::events::effects::decision::Scene;
use crate::events::effects::memory::{Found, Memory};
use crate::events::effects::resting;
use crate::events::effects::transition::transit;
use crate::events::finding::watched::{Watched, unbounded};
use crate::events::forces::holding::Holding;
use crate::events::forces::reporting::Reporting;
use crate::events::modes::drives::Commands;
use crate::events::modes::mode::{JointMode, Mode, MotorMode};
use crate::events::modes::piece_recipe::{OtherMethod, PieceRecipe};
use crate::events::modes::present::Present;
use crate::events::modes::tolerances::slip_at_rest;
use crate::events::parts::model::HybridModel;
use crate::events::parts::previous::PreviousStep;
use crate::events::parts::progress::Progress;
use crate::events::parts::tally::Tally;
use crate::events::parts::traced::{Trace, Traced, TracedJump};
use crate::events::parts::trial::StepTrial;
use crate::events::parts::workspaces::Workspaces;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::Of;
use crate::instant::holding::held::{Closures, Held};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::ground::shared::Shared;
use crate::mechanism::motion::distance::{distance, probes};
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::StepError;
use crate::mechanism::motion::state::State;
use crate::stepping::integrator::MethodError;
use crate::stepping::recipe::{Recipe, Steps};
use std::cell::RefCell;

/// A start that is outside its limits by up to this many times the tolerance of a limit is put there.
const NEARLY: f64 = 1e5;
/// Stages of the steps in the place of a step over events that cannot be made.
const BESIDE: usize = 3;

/// The constrained Lobatto IIIA–IIIB scheme with events.
#[derive(Clone)]
pub struct Eventful {
    pub(super) model: HybridModel,
    /// Which joints are held, which motors are at their bounds, and which contacts are closed: the discrete state.
    pub(super) mode: Mode,
    pub(super) workspaces: Workspaces,
    pub(super) trial: StepTrial,
    pub(super) progress: Progress,
    pub(super) memory: Memory,
    pub(super) tally: Tally,
    pub(super) previous: PreviousStep,
    /// Targets of motors that were given since the last step.
    pub(super) commands: Commands,
    /// The steps and jumps since it was taken last; `None` for a run without derivatives.
    pub(super) trace: Option<Trace>,
}

/// The mode in use, with the room for its accelerations.
pub(super) struct InUse<'a> {
    pub present: Present<'a>,
    pub response: &'a mut Response,
    /// Room for the efforts along the degrees of freedom [N m or N].
    pub efforts: &'a mut Vec<f64>,
    /// Whether forces of contacts are the only ones that hold the motion.
    pub unique: bool,
}

impl Eventful {
    /// For a mechanism with limits, friction or motors.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn new(mechanism: &Mechanism, recipe: Recipe) -> Result<Self, MethodError> {
        Eventful::with(mechanism, PieceRecipe::Lobatto(recipe))
    }

    /// The same events between the steps of another method with this tolerance (m), for comparison; for trees.
    ///
    /// # Errors
    /// As of [`Eventful::new`].
    pub fn between_steps_of(method: OtherMethod, mechanism: &Mechanism, tolerance: f64) -> Result<Self, MethodError> {
        Eventful::with(mechanism, PieceRecipe::Other(method, tolerance))
    }

    /// The number of stages of steps over events: the Lobatto scheme begins with two.
    pub const STAGES_OVER_EVENTS: usize = 1;

    /// Steps of this length (s) over all events, as in crowds ([`crate::events::crowd`]): the implicit midpoint rule, of first order at impacts.
    ///
    /// # Errors
    /// [`MethodError::NeedsEvents`] for joints that are moved in time, rolling and spinning friction, and ropes through several points;
    /// [`MethodError::Step`].
    pub fn over_events(mechanism: &Mechanism, step: f64, kept: &[Rule]) -> Result<Self, MethodError> {
        let steps = Steps::Fixed { stages: BESIDE, step };
        let recipe = Recipe::new(steps, kept.to_vec());
        let mut eventful = Eventful::new(mechanism, recipe)?;
        if eventful.workspaces.crowd.is_none() || eventful.needs_events() {
            return Err(MethodError::NeedsEvents);
        }
        eventful.model.over_events = Some(step);
        Ok(eventful)
    }

    fn with(mechanism: &Mechanism, recipe: PieceRecipe) -> Result<Self, MethodError> {
        // Stages and steps are refused here, not in the middle of the run.
        let idle = recipe.idle(mechanism)?;
        let model = HybridModel::new(mechanism, recipe);
        let mut workspaces = Workspaces::new(mechanism, idle);
        let HybridModel { elements, touching, .. } = &model;
        let mode = Mode {
            joints: vec![JointMode::Free { sliding: 0 }; elements.joints.len()],
            motors: vec![MotorMode::Unbounded; elements.motors.len()],
            contacts: Vec::new(),
            idle: Vec::new(),
            kept: Vec::new(),
            unpressed: Vec::new(),
            seams: Vec::new(),
        };
        let state = State::zero(mechanism);
        let nothing = Held::new(mechanism, &state, vec![false; mechanism.bodies.len()], &Closures::default());
        let present = Present { whole: mechanism, elements, touching, mode: &mode, moving: &nothing, rest: 0.0 };
        let holding = Holding::new(&present, &mut workspaces.response, &state, None);
        Ok(Eventful {
            memory: Memory::new(elements.joints.len()),
            trial: StepTrial::new(&model, holding, state),
            progress: Progress::new(),
            tally: Tally::default(),
            previous: PreviousStep::new(mechanism),
            commands: Commands::Known,
            trace: None,
            workspaces,
            mode,
            model,
        })
    }

    /// Records the sampling error of a step of first order. Samples inside it use the end that is nearer in time, so that the error is half the
    /// displacement.
    pub(super) fn see_jump(&mut self, start: &State, end: &State) {
        let moved = distance(&probes(&self.model.whole, start), &probes(&self.model.whole, end));
        self.workspaces.earlier.see_between(Some(0.5 * moved));
    }

    /// Lets accumulating impacts leave this part of the height that they may leave, and at least this multiple of the least height: runs with finer
    /// steps leave less, and the runs that they are compared with leave more.
    pub fn leave_of_impacts(&mut self, part: f64, least: f64) {
        self.model.leave_of_impacts(part, least);
    }

    /// A program asks for every step.
    pub fn expect_to_be_asked(&mut self) {
        self.model.recipe.expect_to_be_asked();
    }

    /// Makes steps over events and jams longer by a factor, as in a run with which another is compared.
    pub fn coarsen_over_events(&mut self, factor: f64) {
        self.model.coarser = factor;
    }

    /// The sums of the squared lengths of steps over events (s²), and of the lengths of steps over jams (s) so far.
    pub fn smeared(&self) -> [f64; 2] {
        self.tally.smeared
    }

    /// The distance by which flights that were left out of accumulating impacts, and laws that were not solved, can have moved bodies or joints up to an
    /// instant (s) (m or rad).
    pub fn error_of_impacts(&self, time: f64) -> f64 {
        self.tally.error_of_impacts(time)
    }

    /// The distance by which blows in such flights can have moved them up to an instant (s) (m or rad).
    pub fn doubt_of_blows(&self, time: f64) -> f64 {
        self.tally.in_doubt.at(time)
    }

    /// Takes a state that no step has left.
    pub(super) fn begin(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &mut State) -> Result<(), StepError> {
        if self.model.is_other(mechanism) {
            self.model.replace(mechanism);
            self.workspaces.replace(mechanism);
            self.previous.reporting = RefCell::new(Shared::new(Reporting::new(mechanism)));
            self.trial.replace(&self.model);
        }
        if self.previous.left.is_none() {
            self.progress.began = state.time;
        }
        for joint in &self.model.elements.joints {
            for side in joint.sides() {
                let gap = joint.gap(side, joint.position(state));
                let allowed = NEARLY * joint.at_limit(side);
                if gap < -allowed {
                    let name = self.model.whole.bodies[joint.coordinate.body].joint.name.clone();
                    return Err(StepError::OutsideLimit { time: state.time, joint: name, by: -gap });
                }
                if gap.abs() <= allowed {
                    joint.put_on(side, state);
                }
            }
        }
        for (memory, joint) in self.memory.joints.iter_mut().zip(&self.model.elements.joints) {
            memory.fastest = memory.fastest.max(joint.rate(state).abs());
        }
        for index in 0..self.model.elements.motors.len() {
            self.mode.motors[index] = self.motor_mode(index, state);
        }
        for (mode, joint) in self.mode.joints.iter_mut().zip(&self.model.elements.joints) {
            // The decisions at the start are no events.
            *mode = if joint.rate(state) == 0.0 && (joint.friction > 0.0 || joint.side(joint.position(state)).is_some())
            {
                JointMode::Held { on: joint.side(joint.position(state)) }
            } else {
                JointMode::Free { sliding: 0 }
            };
        }
        self.previous.outside.clear();
        self.previous.outside.extend_from_slice(inputs.efforts);
        if self.begin_in_crowd(state) {
            return Ok(());
        }
        let events = self.tally.events.len();
        let exchanged = self.pass_anew(inputs, state);
        self.tally.lost_at_start += exchanged;
        let keep = |event: &Event| event.impulse.is_some();
        let happened: Vec<Event> = self.tally.events.drain(events..).filter(keep).collect();
        self.tally.events.extend(happened);
        Ok(())
    }

    /// Takes a state as the first step from there would, and lets the steps of its mode meet it; whether they go on from there.
    pub fn begin_at(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &mut State) -> bool {
        // The step itself tells an error.
        if self.begin(mechanism, inputs, state).is_err() || self.progress.in_crowd || inputs.feedback.is_some() {
            return false;
        }
        self.previous.left = Some(state.clone());
        inputs.write_constant(&mut self.trial.efforts);
        self.mode.add_constant_efforts(&self.model.elements, &mut self.trial.efforts);
        let piece = self.workspaces.active_mut();
        piece.begin(&self.model.whole, inputs, &self.trial.efforts, state);
        piece.meet();
        true
    }

    /// The mode of a motor in a state, independent of the modes before: a sampled one works out its effort, unless it holds one from the run before.
    pub fn motor_mode(&self, index: usize, state: &State) -> MotorMode {
        let motor = &self.model.elements.motors[index];
        let effort = unbounded(&self.model.elements, index, state.time, state.time, state);
        if motor.period > 0.0 {
            MotorMode::Given(motor.held_at(state.time).unwrap_or_else(|| motor.bounded(effort)))
        } else if effort.abs() >= motor.max_effort {
            MotorMode::Saturated(if effort > 0.0 { 1 } else { -1 })
        } else {
            MotorMode::Unbounded
        }
    }

    /// Carries out the event at a state, and enters the mode that follows; `brief` says that a slip falls to its stop within the shortest step. Returns the energy lost, and the work of driven surfaces.
    pub fn pass(&mut self, inputs: Inputs, state: &mut State, triggers: &[Watched], brief: bool) -> Exchange {
        // Events happen to two motions at two times.
        if self.workspaces.accompanied {
            self.workspaces.leave_companion();
        }
        self.carry_out(inputs, state, Found { triggers, height: self.model.height, anew: false, brief })
    }

    /// The error of a motion that nothing gives way to, if the last event has found one.
    pub(super) fn is_blocked(&mut self, time: f64) -> Result<(), StepError> {
        let Some(of) = self.progress.blocked.take() else { return Ok(()) };
        let whole = &self.model.whole;
        let moved: Vec<String> =
            whole.mimics.iter().filter(|mimic| mimic.is_moved()).map(|mimic| format!("{:?}", mimic.name)).collect();
        let between = match of {
            Of::Joint(joint) => {
                let freedom = self.model.elements.joints[joint].coordinate.freedom;
                format!("joint {:?} and its limit", whole.joint_of_freedom(freedom))
            }
            Of::Contact(pair) | Of::Moment { contact: pair, .. } => {
                let names = self.model.touching.pairs.colliders_of(pair);
                let [a, b] = names.map(|number| whole.nonsmooth.colliders[number].name.as_str());
                format!("{a:?} and {b:?}")
            }
        };
        let moved = format!("the motion of {}", moved.join(", "));
        Err(StepError::Blocked { time, moved, between })
    }

    /// The mode in use.
    pub(super) fn in_use(&mut self) -> InUse<'_> {
        let Workspaces { response, pieces, current, .. } = &mut self.workspaces;
        let HybridModel { whole, elements, touching, .. } = &self.model;
        InUse {
            present: Present {
                whole,
                elements,
                touching,
                mode: &self.mode,
                moving: &pieces[*current].moving,
                rest: slip_at_rest(self.memory.fastest),
            },
            response,
            efforts: &mut self.trial.efforts,
            unique: self.trial.holding.is_unique(),
        }
    }

    /// The same without known contacts: they are looked for everywhere.
    pub(super) fn pass_anew(&mut self, inputs: Inputs, state: &mut State) -> Exchange {
        self.mode.contacts.clear();
        self.carry_out(inputs, state, Found { triggers: &[], height: self.model.height, anew: true, brief: false })
    }

    fn carry_out(&mut self, inputs: Inputs, state: &mut State, found: Found) -> Exchange {
        self.progress.asleep = false;
        let before = self.trace.is_some().then(|| state.clone());
        self.look_around(state);
        let Eventful {
            model: HybridModel { elements, touching, whole, .. },
            workspaces: Workspaces { response, .. },
            tally: Tally { solvers, .. },
            trial: StepTrial { near, .. },
            mode,
            memory,
            ..
        } = self;
        let efforts = |mode: &Mode, state: &State| mode.driving_efforts(elements, inputs, state);
        let had = whole.moves_joints().then(|| resting::energy(whole, state).total());
        let mut scene = Scene { whole, elements, touching, near: near.pairs(), response, solvers };
        let done = transit(&mut scene, mode, state, memory, &found, efforts);
        // Impulses that hold a moved joint at its rate do work, too: the rest of the balance.
        let rest = |had: f64| resting::energy(&self.model.whole, state).total() - had + done.lost;
        let work = had.map_or(done.driven, rest);
        self.tally.events.extend(done.events);
        self.tally.unsolved += done.unsolved;
        if done.blocked.is_some() {
            // The run ends here.
            self.progress.blocked = done.blocked;
            return Exchange::default();
        }
        let (rebounds, energy) = done.cut;
        self.tally.leave_out(rebounds, energy, &self.model.whole, state);
        self.tally.left_of_impacts += done.left;
        self.tally.in_doubt.add(done.speed_in_doubt, state.time);
        self.tally.unsolved_blows.add(done.speed_of_unsolved, state.time);
        (self.trial.fresh_joints, self.trial.fresh_motors, self.trial.fresh_pairs) =
            (done.joints, done.motors, done.pairs);
        self.enter(state);
        self.progress.undecided = done.undecided || done.unsolved > 0 && self.is_far_out(inputs, state);
        if self.stays_at_rest(inputs, state) {
            self.progress.asleep = true;
            self.enter(state);
        }
        if let (Some(trace), Some(before)) = (&mut self.trace, before) {
            let (meetings, contacts) = (done.meetings, done.contacts);
            trace.entries.push(Traced::Jump(Box::new(TracedJump { before, after: state.clone(), meetings, contacts })));
        }
        Exchange { impacts: done.lost, work, ..Exchange::default() }
    }
}

//! The integrator of motions that are smooth in pieces: steps of the scheme for the reduced mechanism of a mode, ended at events.

use crate::events::crowd::step::Crowd;
use crate::events::crowding::Crowding;
use crate::events::effects::decision::Scene;
use crate::events::effects::memory::{Found, Memory};
use crate::events::effects::resting;
use crate::events::effects::transition::transit;
use crate::events::finding::cover::Cover;
use crate::events::finding::detection::Looking;
use crate::events::finding::reserves::Reserves;
use crate::events::finding::speeds::Speeds;
use crate::events::finding::watched::{Watched, unbounded};
use crate::events::forces::holding::Holding;
use crate::events::forces::reporting::Reporting;
use crate::events::modes::drives::Commands;

use crate::events::modes::instants::Evaluated;
use crate::events::modes::mode::{JointMode, Mode, MotorMode};
use crate::events::modes::narrowed::Felt;
use crate::events::modes::piece::Piece;
use crate::events::modes::piece_steps::PieceRecipe;
use crate::events::modes::placed::PlacedBodies;
use crate::events::modes::present::Present;
use crate::events::repeats::Repeats;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::held::Closures;
use crate::instant::holding::held::Held;
use crate::instant::holding::touching::Touching;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::ground::shared::Shared;
use crate::mechanism::motion::distance::{distance, probes};
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{ContactSolvers, Cost, MethodDescription, StepError};
use crate::mechanism::motion::state::State;
use crate::stepping::integrator::MethodError;
use crate::stepping::recipe::Recipe;
use nalgebra::Vector3;
use std::cell::RefCell;
use std::sync::Arc;

/// A start that is outside its limits by up to this many times the tolerance of a limit is put there.
const NEARLY: f64 = 1e5;
/// The height that accumulating impacts may leave without a tolerance (rad or m).
const HEIGHT: f64 = 1e-13;
/// The same over a tolerance.
const LEFT: f64 = 1e-4;
/// Rebounds that are left out are told where they would have given back more than this part of the kinetic energy.
const MATTERS: f64 = 1e-9;

/// The constrained Lobatto IIIA–IIIB scheme with events.
#[derive(Clone)]
pub struct Eventful {
    pub(super) whole: Arc<Mechanism>,
    pub(super) elements: Elements,
    pub(super) recipe: PieceRecipe,
    pub(super) response: Response,
    pub(super) touching: Arc<Touching>,
    pub(super) mode: Mode,
    pub(super) memory: Memory,
    pub(super) pieces: Vec<Shared<Piece>>,
    /// The piece in use, and the piece of the last step.
    pub(super) current: usize,
    pub(super) last: usize,
    pub(super) watched: Vec<Watched>,
    pub(super) holding: Holding,
    /// Functions whose zero at the start of the next step is no event.
    pub(super) fresh_joints: Vec<bool>,
    pub(super) fresh_motors: Vec<bool>,
    pub(super) fresh_pairs: Vec<bool>,
    /// The states at which the last step began and ended, the second one after all events there.
    pub(super) origin: State,
    pub(super) left: Option<State>,
    pub(super) sample: State,
    /// The evaluated functions of that sample.
    pub(super) evaluated: Evaluated,
    /// Room for looks at steps.
    pub(super) looking: Looking,
    pub(super) speeds: Speeds,
    /// How far pairs are from closing, by the looks at steps before.
    pub(super) reserves: Reserves,
    /// The covered stretches of the last step for each pair that may close in it, by its number among the watched functions.
    pub(super) covers: Vec<(usize, Cover)>,
    /// A bound of the overlap of all pairs in the last step (m).
    pub(super) overlap: f64,
    pub(super) bodies: Vec<BodyState>,
    /// The bodies in the latest states.
    pub(super) placed: PlacedBodies,
    /// The directions in which closed contacts slide where the step begins.
    pub(super) slips: Vec<Vector3<f64>>,
    pub(super) efforts: Vec<f64>,
    pub(super) events: Vec<Event>,
    /// The efforts from outside in the last step.
    pub(super) outside: Vec<f64>,
    /// Efforts in the last step that follow the state.
    pub(super) felt: Felt,
    /// When the run began (s).
    pub(super) began: f64,
    /// Whether a given instant bounds the next step, and not only the end of the run.
    pub(super) bounded: bool,
    /// Events that may repeat, and the functions that the step does not look at.
    pub(super) repeats: Repeats,
    /// The cost of attempts that were thrown away, which no outcome has yet.
    pub(super) abandoned: Cost,
    pub(super) steps: usize,
    pub(super) stepped: f64,
    pub(super) lost_at_start: Exchange,
    /// Method description used while every joint is held.
    pub(super) idle: MethodDescription,
    /// The error of samples inside the steps of modes that are not kept any more, and in steps of first order (m).
    pub(super) between: Option<f64>,
    /// The part of it in steps that were too long for a damper (m).
    pub(super) ringing: f64,
    /// Number of laws of contact that could not be solved to their accuracy.
    pub(super) unsolved: usize,
    /// How often each contact solver has solved a problem of an event.
    pub(super) solvers: ContactSolvers,
    /// Number of rebounds left out in crowds of impacts and in steps of first order, and the energy that they would have given back (J).
    pub(super) cut: (usize, f64),
    /// The distance by which the ends of accumulating impacts can have moved bodies or joints so far (m or rad).
    pub(super) left_of_impacts: f64,
    /// The height that they may leave (m or rad).
    height: f64,
    /// Whether it could not be solved at all where the last step ended: the next one is of first order.
    pub(super) undecided: bool,
    /// Steps of first order, and how long they were together (s).
    pub(super) first_order: (usize, f64),
    /// Whether all bodies rest on contacts, and stay there until the next event.
    pub(super) asleep: bool,
    /// Consecutive steps at rest.
    pub(super) quiet: usize,
    /// The counts of crowds of events.
    pub(super) crowding: Crowding,
    /// The workspace of steps over many impacts, and whether the run makes them now.
    pub(super) crowd: Option<Box<Crowd>>,
    pub(super) in_crowd: bool,
    /// The largest residual and the largest lift of these steps (m).
    pub(super) crowd_figures: (f64, f64),
    /// The end of the last step, if it was one of first order.
    pub(super) stepped_over: Option<State>,
    /// The mode of the last step, where there are pairs that may touch.
    pub(super) stepped_in: Option<Mode>,
    /// For the forces that are reported.
    pub(super) reporting: RefCell<Reporting>,
    /// Whether a companion goes along until the first event.
    pub(super) accompanied: bool,
    /// Targets of motors that were given since the last step.
    pub(super) commands: Commands,
}

/// The larger of two errors, if both are known.
pub(super) fn larger(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    Some(one?.max(other?))
}

impl Eventful {
    /// For a mechanism with limits, friction or motors.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn new(mechanism: &Mechanism, recipe: Recipe) -> Result<Self, MethodError> {
        Eventful::with(mechanism, PieceRecipe::Lobatto(recipe))
    }

    /// The comparator: the same events, between steps of DOP853 in joint coordinates with this tolerance; for trees.
    pub fn over_dop853(mechanism: &Mechanism, tolerance: f64) -> Result<Self, MethodError> {
        Eventful::with(mechanism, PieceRecipe::Dop853(tolerance))
    }

    fn with(mechanism: &Mechanism, recipe: PieceRecipe) -> Result<Self, MethodError> {
        // Stages and steps are refused here, not in the middle of the run.
        let idle = recipe.idle(mechanism)?;
        let height = recipe.tolerance().map_or(HEIGHT, |tolerance| HEIGHT.max(LEFT * tolerance));
        let elements = Elements::new(mechanism);
        let mode = Mode {
            joints: vec![JointMode::Free { sliding: 0 }; elements.joints.len()],
            motors: vec![MotorMode::Unbounded; elements.motors.len()],
            contacts: Vec::new(),
            idle: Vec::new(),
        };
        let touching = Arc::new(Touching::new(mechanism));
        let state = State::zero(mechanism);
        let mut response = Response::new(mechanism);
        let nothing = Held::new(mechanism, &state, vec![false; mechanism.bodies.len()], &Closures::default());
        let holding = {
            let present =
                Present { whole: mechanism, elements: &elements, touching: &touching, mode: &mode, moving: &nothing };
            Holding::new(&present, &mut response, &state)
        };
        Ok(Eventful {
            memory: Memory::new(elements.joints.len(), touching.pairs.len()),
            fresh_pairs: vec![false; touching.pairs.len()],
            speeds: Speeds::default(),
            reserves: Reserves::default(),
            placed: PlacedBodies::default(),
            covers: Vec::new(),
            overlap: 0.0,
            bodies: vec![WORLD; mechanism.bodies.len()],
            slips: Vec::new(),
            touching,
            fresh_joints: vec![false; elements.joints.len()],
            fresh_motors: vec![false; elements.motors.len()],
            response,
            mode,
            elements,
            recipe,
            pieces: Vec::new(),
            current: 0,
            last: 0,
            watched: Vec::new(),
            holding,
            origin: state.clone(),
            sample: state,
            evaluated: Evaluated::default(),
            looking: Looking::default(),
            left: None,
            efforts: vec![0.0; mechanism.velocity_count],
            events: Vec::new(),
            outside: Vec::new(),
            felt: Felt::default(),
            began: 0.0,
            bounded: false,
            repeats: Repeats::new(),
            abandoned: Cost::default(),
            steps: 0,
            stepped: 0.0,
            lost_at_start: Exchange::default(),
            idle,
            between: Some(0.0),
            ringing: 0.0,
            unsolved: 0,
            solvers: ContactSolvers::default(),
            cut: (0, 0.0),
            left_of_impacts: 0.0,
            height,
            undecided: false,
            first_order: (0, 0.0),
            crowding: Crowding::CALM,
            crowd: Crowd::new(mechanism).map(Box::new),
            in_crowd: false,
            crowd_figures: (0.0, 0.0),
            stepped_over: None,
            asleep: false,
            quiet: 0,
            stepped_in: None,
            reporting: RefCell::new(Reporting::new(mechanism)),
            accompanied: false,
            commands: Commands::Known,
            whole: Arc::new(mechanism.clone()),
        })
    }

    /// Whether stability, and not accuracy, has limited a step.
    pub fn was_held_by_stability(&self) -> bool {
        self.pieces.iter().filter_map(|piece| piece.steps.as_ref()).any(|steps| steps.was_held_by_stability())
    }

    /// The error of samples inside the steps so far, beside the error of their ends (m); `None` if it is not known.
    pub fn between(&self) -> Option<f64> {
        let pieces = self.pieces.iter().filter_map(|piece| piece.steps.as_ref());
        pieces.map(|steps| steps.between()).fold(self.between, larger)
    }

    /// The largest error of samples inside steps that were too long for a damper, so far (m).
    pub fn ringing_inside(&self) -> f64 {
        let pieces = self.pieces.iter().filter_map(|piece| piece.steps.as_ref());
        pieces.map(|steps| steps.ringing_inside()).fold(self.ringing, f64::max)
    }

    /// Records the sampling error of a step of first order. Samples inside it use the end that is nearer in time, so that the error is half the
    /// displacement.
    pub(super) fn see_jump(&mut self, start: &State, end: &State) {
        let moved = distance(&probes(&self.whole, start), &probes(&self.whole, end));
        self.between = larger(self.between, Some(0.5 * moved));
    }

    /// Carries a companion from the first step on, which shows what errors the steps make, up to the first event.
    pub(crate) fn accompany(&mut self) {
        self.accompanied = true;
    }

    /// Carries it no more.
    pub(crate) fn leave_companion(&mut self) {
        self.accompanied = false;
        self.pieces.iter_mut().filter_map(|piece| piece.steps.as_mut()).for_each(|steps| steps.leave_companion());
    }

    /// Writes the state of the companion after the last step; `false` without a companion.
    pub(crate) fn place_companion(&self, state: &mut State) -> bool {
        let Some(piece) = self.pieces.get(self.current).filter(|_| self.accompanied) else { return false };
        let Some(companion) = piece.steps.as_ref().and_then(|steps| steps.companion()) else { return false };
        piece.moving.spread(&self.whole, companion.state(), state);
        true
    }

    /// Lets accumulating impacts leave this part of the height that they may leave, and at least this multiple of the least height: runs with finer
    /// steps leave less, and the runs that they are compared with leave more.
    pub(crate) fn leave_of_impacts(&mut self, part: f64, least: f64) {
        self.height = (least * HEIGHT).max(part * self.recipe.tolerance().map_or(HEIGHT, |tolerance| LEFT * tolerance));
    }

    /// The distance by which the ends of accumulating impacts can have moved bodies or joints so far (m or rad).
    pub(crate) fn left_of_impacts(&self) -> f64 {
        self.left_of_impacts
    }

    /// Whether another mechanism than the one that is known acts.
    pub(super) fn is_other(&self, mechanism: &Mechanism) -> bool {
        let own = &self.whole;
        own.gravity != mechanism.gravity || !own.forces.are_those_of(&mechanism.forces)
    }

    /// Takes a state that no step has left.
    pub(super) fn begin(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &mut State) -> Result<(), StepError> {
        if self.is_other(mechanism) {
            self.whole = Arc::new(mechanism.clone());
            self.response = Response::new(mechanism);
            self.reporting = RefCell::new(Reporting::new(mechanism));
            self.touching = Arc::new(Touching::new(mechanism));
            self.pieces.clear();
            self.crowd = Crowd::new(mechanism).map(Box::new);
            self.placed.forget();
        }
        if self.left.is_none() {
            self.began = state.time;
        }
        for joint in &self.elements.joints {
            for side in joint.sides() {
                let gap = joint.gap(side, joint.position(state));
                let allowed = NEARLY * joint.at_limit(side);
                if gap < -allowed {
                    let name = self.whole.bodies[joint.coordinate.body].joint.name.clone();
                    return Err(StepError::OutsideLimit { time: state.time, joint: name, by: -gap });
                }
                if gap.abs() <= allowed {
                    joint.put_on(side, state);
                }
            }
        }
        for (memory, joint) in self.memory.joints.iter_mut().zip(&self.elements.joints) {
            memory.fastest = memory.fastest.max(joint.rate(state).abs());
        }
        for index in 0..self.elements.motors.len() {
            self.mode.motors[index] = self.motor_mode(index, state);
        }
        for (mode, joint) in self.mode.joints.iter_mut().zip(&self.elements.joints) {
            // The decisions at the start are no events.
            *mode = if joint.rate(state) == 0.0 && (joint.friction > 0.0 || joint.side(joint.position(state)).is_some())
            {
                JointMode::Held { on: joint.side(joint.position(state)) }
            } else {
                JointMode::Free { sliding: 0 }
            };
        }
        self.outside.clear();
        self.outside.extend_from_slice(inputs.efforts);
        let events = self.events.len();
        let exchanged = self.pass_anew(inputs, state);
        self.lost_at_start += exchanged;
        let keep = |event: &Event| event.impulse.is_some();
        let happened: Vec<Event> = self.events.drain(events..).filter(keep).collect();
        self.events.extend(happened);
        Ok(())
    }

    /// The mode of a motor in a state, independent of the modes before.
    pub(super) fn motor_mode(&self, index: usize, state: &State) -> MotorMode {
        let motor = &self.elements.motors[index];
        let effort = unbounded(&self.elements, index, state.time, state.time, state);
        if motor.period > 0.0 {
            MotorMode::Given(motor.bounded(effort))
        } else if effort.abs() >= motor.max_effort {
            MotorMode::Saturated(if effort > 0.0 { 1 } else { -1 })
        } else {
            MotorMode::Unbounded
        }
    }

    /// Carries out the event at a state, and enters the mode that follows; returns the energy lost, and the work of driven surfaces.
    pub(super) fn pass(&mut self, inputs: Inputs, state: &mut State, triggers: &[Watched]) -> Exchange {
        // Events happen to two motions at two times.
        if self.accompanied {
            self.leave_companion();
        }
        self.carry_out(inputs, state, Found { triggers, height: self.height, anew: false })
    }

    /// The same without known contacts: they are looked for everywhere.
    pub(super) fn pass_anew(&mut self, inputs: Inputs, state: &mut State) -> Exchange {
        self.mode.contacts.clear();
        self.carry_out(inputs, state, Found { triggers: &[], height: self.height, anew: true })
    }

    fn carry_out(&mut self, inputs: Inputs, state: &mut State, found: Found) -> Exchange {
        self.asleep = false;
        let Eventful { elements, touching, mode, response, memory, whole, solvers, .. } = self;
        let efforts = |mode: &Mode, state: &State| mode.driving_efforts(elements, inputs, state);
        let mut scene = Scene { whole, elements, touching, response, solvers };
        let done = transit(&mut scene, mode, state, memory, &found, efforts);
        self.events.extend(done.events);
        self.unsolved += done.unsolved;
        let (rebounds, energy) = done.cut;
        self.leave_out(rebounds, energy, state);
        self.left_of_impacts += done.left;
        (self.fresh_joints, self.fresh_motors, self.fresh_pairs) = (done.joints, done.motors, done.pairs);
        self.enter(state);
        self.undecided = done.undecided || done.unsolved > 0 && self.is_far_out(inputs, state);
        if self.stays_at_rest(inputs, state) {
            self.asleep = true;
            self.enter(state);
        }
        Exchange { impacts: done.lost, work: done.driven, ..Exchange::default() }
    }

    /// Notes rebounds that were left out before a state, and the energy that they would have given back (J), unless it is tiny beside the kinetic
    /// energy.
    pub(super) fn leave_out(&mut self, rebounds: usize, energy: f64, state: &State) {
        if rebounds > 0 && energy > MATTERS * resting::energy(&self.whole, state).kinetic {
            self.cut = (self.cut.0 + rebounds, self.cut.1 + energy);
        }
    }

    /// The next instant at which an effort changes its law, or the end.
    pub(super) fn next_instant(&self, time: f64, until: f64) -> f64 {
        let motors = self.elements.motors.iter().map(|motor| motor.next_instant(time));
        let next = motors.fold(until.min(self.whole.forces.next_instant(time)), f64::min);
        if until - next < 1e-12 * until.abs().max(1.0) { until } else { next }
    }
}

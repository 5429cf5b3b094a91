//! The integrator of motions that are smooth in pieces: steps of the scheme for what moves in a mode, ended at events.

use crate::events::decision::held_bodies;
use crate::events::detection::Looking;
use crate::events::drives::Drives;
use crate::events::held::Held;
use crate::events::holding::{Holding, Present};
use crate::events::mode::{JointMode, Mode, MotorMode};
use crate::events::piece::{Key, Piece};
use crate::events::transition::{Found, Memory, transit};
use crate::events::watched::{Watched, unbounded};
use crate::instant::elements::Elements;
use crate::instant::response::Response;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription, StepError};
use crate::mechanism::motion::state::State;
use crate::stepping::integrator::{Lobatto, MethodError, StepPace};
use crate::stepping::recipe::{Recipe, Steps};

/// Modes whose workspaces are kept.
const KEPT_MODES: usize = 12;
/// A start that is outside its limits by so many times what counts as being on them is put there.
const NEARLY: f64 = 1e5;
/// What may be left of the height of accumulating impacts, where no tolerance says so (rad or m).
const HEIGHT: f64 = 1e-13;

/// The constrained Lobatto IIIA–IIIB scheme with events.
pub struct Eventful {
    pub(super) whole: Mechanism,
    pub(super) elements: Elements,
    pub(super) recipe: Recipe,
    pub(super) response: Response,
    pub(super) mode: Mode,
    pub(super) memory: Memory,
    pub(super) pieces: Vec<Piece>,
    /// The piece in use, and that of the last step.
    pub(super) current: usize,
    pub(super) last: usize,
    pub(super) watched: Vec<Watched>,
    pub(super) holding: Holding,
    /// Functions whose zero at the start of the next step is no event.
    pub(super) fresh_joints: Vec<bool>,
    pub(super) fresh_motors: Vec<bool>,
    /// Where the last step began, and where it ended, with everything that happened there.
    pub(super) origin: State,
    pub(super) left: Option<State>,
    pub(super) sample: State,
    /// Room for looks at steps.
    pub(super) looking: Looking,
    pub(super) efforts: Vec<f64>,
    pub(super) events: Vec<Event>,
    /// The efforts from outside in the last step.
    pub(super) outside: Vec<f64>,
    /// When the run began (s).
    pub(super) began: f64,
    pub(super) flips: (usize, f64),
    /// How often in a row an event at the start of a step has changed nothing.
    pub(super) unfounded: i32,
    /// Whether the next step does not look for events.
    pub(super) looks_away: bool,
    pub(super) steps: usize,
    pub(super) stepped: f64,
    pub(super) lost_at_start: f64,
    /// What stands for the steps where nothing moves.
    pub(super) idle: MethodDescription,
}

impl Eventful {
    /// For a mechanism with limits, friction or motors.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn new(mechanism: &Mechanism, recipe: Recipe) -> Result<Self, MethodError> {
        // Stages and steps are refused here, not in the middle of the run.
        let idle = recipe.lobatto(mechanism)?.description();
        let elements = Elements::new(mechanism);
        let mode = Mode {
            joints: vec![JointMode::Free { sliding: 0 }; elements.joints.len()],
            motors: vec![MotorMode::Unbounded; elements.motors.len()],
        };
        let state = State::zero(mechanism);
        let mut response = Response::new(mechanism);
        let nothing = Held::new(mechanism, &state, vec![false; mechanism.bodies.len()]);
        let holding = {
            let present = Present { whole: mechanism, elements: &elements, mode: &mode, moving: &nothing };
            Holding::new(&present, &mut response, &state)
        };
        Ok(Eventful {
            memory: Memory::new(elements.joints.len()),
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
            looking: Looking::default(),
            left: None,
            efforts: vec![0.0; mechanism.velocity_count],
            events: Vec::new(),
            outside: Vec::new(),
            began: 0.0,
            flips: (0, f64::MIN),
            unfounded: 0,
            looks_away: false,
            steps: 0,
            stepped: 0.0,
            lost_at_start: 0.0,
            idle,
            whole: mechanism.clone(),
        })
    }

    /// Whether stability, and not accuracy, has limited a step.
    pub fn was_held_by_stability(&self) -> bool {
        self.pieces.iter().filter_map(|piece| piece.lobatto.as_ref()).any(Lobatto::was_held_by_stability)
    }

    /// The height that accumulating impacts may leave.
    fn height(&self) -> f64 {
        match self.recipe.steps {
            Steps::Fixed { .. } => HEIGHT,
            Steps::Chosen { tolerance, .. } => HEIGHT.max(1e-4 * tolerance),
        }
    }

    /// Whether another mechanism than the one that is known acts.
    pub(super) fn is_other(&self, mechanism: &Mechanism) -> bool {
        let own = &self.whole;
        own.gravity != mechanism.gravity || !own.forces.are_those_of(&mechanism.forces)
    }

    /// Takes a state that no step has left.
    pub(super) fn begin(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &mut State) -> Result<(), StepError> {
        if self.is_other(mechanism) {
            self.whole = mechanism.clone();
            self.response = Response::new(mechanism);
            self.pieces.clear();
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
            // What is decided now is no event.
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
        self.lost_at_start += self.pass(inputs, state, &[]);
        let keep = |event: &Event| event.impulse.is_some();
        let happened: Vec<Event> = self.events.drain(events..).filter(keep).collect();
        self.events.extend(happened);
        Ok(())
    }

    /// What a motor does in a state, from nothing that was before.
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

    /// Carries out the event at a state, and enters the mode that follows; returns the energy lost (J).
    pub(super) fn pass(&mut self, inputs: Inputs, state: &mut State, triggers: &[Watched]) -> f64 {
        let found = Found { triggers, height: self.height() };
        let Eventful { elements, mode, response, memory, whole, .. } = self;
        let efforts = |mode: &Mode, state: &State| {
            let mut efforts = vec![0.0; whole.velocity_count];
            efforts[..inputs.efforts.len()].copy_from_slice(inputs.efforts);
            let motors = Mode { joints: Vec::new(), motors: mode.motors.clone() };
            motors.add_constant_efforts(elements, &mut efforts);
            motors.add_motor_efforts(elements, state.time, state.time, state, &mut efforts);
            efforts
        };
        let done = transit(elements, mode, response, state, memory, &found, efforts);
        self.events.extend(done.events);
        (self.fresh_joints, self.fresh_motors) = (done.joints, done.motors);
        self.enter(state);
        done.lost
    }

    /// Finds or makes what moves in the mode, and what is watched in it.
    fn enter(&mut self, state: &mut State) {
        let Eventful { whole, elements, mode, response, .. } = self;
        let held = held_bodies(whole, elements, mode, response, state);
        for (body, _) in whole.bodies.iter().zip(&held).filter(|(_, held)| **held) {
            state.velocity[body.joint.velocity_range()].fill(0.0);
        }
        response.close_velocities(state);
        for (body, _) in whole.bodies.iter().zip(&held).filter(|(_, held)| **held) {
            state.velocity[body.joint.velocity_range()].fill(0.0);
        }
        let places = whole.bodies.iter().zip(&held).filter(|(_, held)| **held);
        let places = places.map(|(body, _)| state.position[body.joint.position_index]).collect();
        let motors = mode.motors.iter().map(|motor| *motor == MotorMode::Unbounded).collect();
        let key = Key { held, places, motors };
        let pace = self.pieces.get(self.current).and_then(|piece| piece.lobatto.as_ref());
        let pace = pace.map_or(StepPace::Grid { origin: self.began }, |lobatto| lobatto.step_pace(self.began));
        self.current = self.piece(key, state);
        let piece = &mut self.pieces[self.current];
        piece.used = self.steps;
        piece.small = piece.moving.gather(&self.whole, state);
        if let Some(lobatto) = &mut piece.lobatto {
            lobatto.keep_pace(pace, state.time);
        }
        let Piece { moving, .. } = piece;
        self.holding = {
            let present = Present { whole: &self.whole, elements: &self.elements, mode: &self.mode, moving };
            Holding::new(&present, &mut self.response, state)
        };
        self.watched = Watched::of(&self.elements, &self.mode, self.holding.is_unique());
    }

    /// The number of the piece with this key.
    fn piece(&mut self, key: Key, state: &State) -> usize {
        if let Some(known) = self.pieces.iter().position(|piece| piece.key == key) {
            return known;
        }
        let mut moving = Held::new(&self.whole, state, key.held.clone());
        let drives = Drives::add(&self.elements, &self.mode, &self.whole, &mut moving);
        // Stages and steps were accepted for the whole.
        let lobatto = if moving.is_empty() { None } else { self.recipe.lobatto(&moving.mechanism).ok() };
        let (positions, freedoms) = (moving.mechanism.position_count, moving.mechanism.velocity_count);
        let small = State::zero(&moving.mechanism);
        let piece = Piece {
            key,
            drives,
            lobatto,
            small_start: small.clone(),
            small,
            small_efforts: vec![0.0; freedoms],
            small_position: vec![0.0; positions],
            small_velocity: vec![0.0; freedoms],
            used: self.steps,
            moving,
        };
        let oldest =
            (0..self.pieces.len()).filter(|&index| index != self.last).min_by_key(|&index| self.pieces[index].used);
        match oldest {
            Some(oldest) if self.pieces.len() >= KEPT_MODES => {
                self.pieces[oldest] = piece;
                oldest
            }
            _ => {
                self.pieces.push(piece);
                self.pieces.len() - 1
            }
        }
    }

    /// The next instant at which an effort changes its law, or the end.
    pub(super) fn next_instant(&self, time: f64, until: f64) -> f64 {
        let motors = self.elements.motors.iter().map(|motor| motor.next_instant(time));
        let next = motors.fold(until, f64::min);
        if until - next < 1e-12 * until.abs().max(1.0) { until } else { next }
    }
}

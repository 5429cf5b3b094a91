//! The mechanism that moves in a state: for equations that hold until the next event.
//!
//! The mode of a state is decided as at the start of a run ([`crate::events::modes::mode`]): held joints are parts of their parents, motors are
//! springs, dampers and efforts, closed contacts that stick and taut ropes are closures, and contacts that roll or slide are touches. Sampled motors count
//! as motors that follow their laws at every instant.

use crate::events::integrator::Eventful;
use crate::events::modes::drives::Drives;
use crate::events::modes::mode::{Closed, JointMode, MotorMode};
use crate::instant::holding::held::Held;
use crate::instant::holding::rope::is_rope;
use crate::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use crate::mechanism::description::contact::{Grip, Moments, TouchJoint};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::MotorLaw;
use crate::mechanism::ground::words::counted;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::inputs::{ChangingEfforts, Inputs};
use crate::mechanism::motion::integrator::StepError;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use crate::stepping::integrator::MethodError;
use crate::stepping::recipe::{Recipe, Steps};
use nalgebra::DVector;
use std::sync::Arc;

/// A contact that slips less than this begins to slide [m/s].
const SLIPLESS: f64 = 1e-12;
/// Frames of features that differ by less are one (m, rad).
const SAME_PLACE: f64 = 1e-6;

/// A joint that does not move, and its cause.
#[derive(Clone, Debug, PartialEq)]
pub struct Stuck {
    pub joint: String,
    /// On this limit, or by friction alone.
    pub on: Option<Side>,
}

impl Stuck {
    /// Its cause in words.
    pub fn reason(&self) -> &'static str {
        match self.on {
            None => "friction",
            Some(Side::Lower) => "lower limit",
            Some(Side::Upper) => "upper limit",
        }
    }
}

/// A motor as it acts in a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Driving {
    /// Its number among the motors.
    pub motor: usize,
    /// The degree of freedom of the mechanism that moves; `None` if it is held.
    pub freedom: Option<usize>,
    /// The effort for each unit of its target; zero at its bound.
    pub by_target: f64,
    /// Whether it is at its bound.
    pub saturated: bool,
}

/// The mechanism that moves.
#[derive(Clone)]
pub struct Moving {
    whole: Arc<Mechanism>,
    held: Arc<Held>,
    /// The state of the mechanism that moves.
    pub state: State,
    /// Efforts along its degrees of freedom that do not depend on the state, at its time [N m or N].
    pub efforts: DVector<f64>,
    /// The part that is the same at all times, and motors with targets that change.
    constant: DVector<f64>,
    drives: Drives,
    pub stuck: Vec<Stuck>,
    pub motors: Vec<Driving>,
    /// Contacts that are closed and stick at a point.
    pub sticking: usize,
}

/// The mechanism that moves cannot be told.
#[derive(Debug, thiserror::Error)]
pub enum MovingError {
    /// No integrator takes the mechanism.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The state cannot be.
    #[error(transparent)]
    State(#[from] StepError),
    /// Contacts have moments of friction, or belts.
    #[error(
        "{} rolling or spinning friction or a belt here, and linear equations know neither; \
         leave contact out with --contact none, or take an instant without these contacts",
        counted(*count, "closed contact has", "closed contacts have")
    )]
    Contacts { count: usize },
    /// Ropes through several points are taut.
    #[error(
        "{} here, and linear equations know ropes between two points alone; \
         take an instant at which they are slack",
        counted(*count, "taut rope through several points pulls", "taut ropes through several points pull")
    )]
    Reeved { count: usize },
}

impl Moving {
    /// In a state of a mechanism, under efforts along its degrees of freedom.
    ///
    /// # Errors
    /// [`MovingError`] for states outside of limits, and contacts that linear equations do not know.
    pub fn at(mechanism: &Mechanism, state: &State, efforts: &[f64]) -> Result<Self, MovingError> {
        let mut whole = mechanism.clone();
        whole.nonsmooth.motors.iter_mut().for_each(|motor| motor.period = 0.0);
        let recipe = Recipe::new(Steps::Fixed { stages: 2, step: 1e-3 }, Vec::new());
        let mut eventful = Eventful::new(&whole, recipe)?;
        let mut state = state.clone();
        eventful.begin(&whole, Inputs::constant(efforts), &mut state)?;
        eventful.wake(&mut state);
        eventful.moving(whole, &state, efforts)
    }

    /// The mechanism that moves.
    pub fn mechanism(&self) -> &Mechanism {
        &self.held.mechanism
    }

    /// The state of the whole mechanism for a state of this one; `state` has the places of held joints.
    pub fn spread(&self, own: &State, state: &mut State) {
        self.held.spread(&self.whole, own, state);
    }

    /// The efforts that do not depend on the state at a time (s), with the pieces of targets that begin at or before `since` (s).
    pub fn efforts_at(&mut self, since: f64, time: f64) -> DVector<f64> {
        self.drives.begin(since);
        let mut efforts = self.constant.clone();
        for (entry, &freedom) in self.drives.freedoms().iter().enumerate() {
            efforts[freedom] += self.drives.effort(entry, time);
        }
        efforts
    }

    /// The degree of freedom of the whole mechanism for each one of this mechanism.
    pub fn freedoms_of_whole(&self) -> Vec<usize> {
        let mut freedoms = vec![0; self.held.mechanism.velocity_count];
        for freedom in 0..self.whole.velocity_count {
            if let Some(own) = self.held.freedom(&self.whole, freedom) {
                freedoms[own] = freedom;
            }
        }
        freedoms
    }

    /// The number of contacts that roll, and of contacts that slide.
    pub fn rolling_and_sliding(&self) -> [usize; 2] {
        let touches = &self.held.mechanism.touches;
        let rolling = touches.iter().filter(|touch| touch.touch.grip == Grip::Rolls).count();
        [rolling, touches.len() - rolling]
    }

    /// The number of contacts with friction that begin to slide: it has two directions there, and no derivative.
    pub fn beginning_to_slide(&self) -> usize {
        let bodies = body_states(&self.held.mechanism, &self.state);
        let begins =
            |joint: &&TouchJoint| joint.touch.friction() > 0.0 && touch_motion(joint, &bodies).slip.norm() <= SLIPLESS;
        self.held.mechanism.touches.iter().filter(begins).count()
    }

    /// Lets contacts with friction roll, as they do at an equilibrium.
    pub fn let_roll(&mut self) {
        let slides = |joint: &TouchJoint| joint.touch.friction() > 0.0;
        if self.held.mechanism.touches.iter().any(slides) {
            let touches = &mut Arc::make_mut(&mut self.held).mechanism.touches;
            touches.iter_mut().filter(|joint| slides(joint)).for_each(|joint| joint.touch.grip = Grip::Rolls);
        }
    }

    /// Whether the same joints are stuck, motors at their bounds, and contacts closed as of another one.
    pub fn is_like(&self, other: &Moving) -> bool {
        let [own, others] = [self, other].map(|moving| &moving.held.mechanism.touches);
        let are_near = |one: &Attachment, other: &Attachment| {
            one.body == other.body && (one.frame.to_homogeneous() - other.frame.to_homogeneous()).amax() <= SAME_PLACE
        };
        let is_same = |one: &TouchJoint, other: &TouchJoint| {
            let rolls = [one, other].map(|joint| joint.touch.grip == Grip::Rolls);
            one.touch.features == other.touch.features
                && rolls[0] == rolls[1]
                && are_near(&one.a, &other.a)
                && are_near(&one.b, &other.b)
        };
        (&self.stuck, &self.motors, self.sticking) == (&other.stuck, &other.motors, other.sticking)
            && own.len() == others.len()
            && own.iter().zip(others).all(|(one, other)| is_same(one, other))
    }

    /// The degrees of freedom that motors drive.
    pub fn driven(&self) -> Vec<usize> {
        self.motors.iter().filter_map(|motor| motor.freedom).collect()
    }
}

/// The closure of a rope between two points that is taut: their distance.
fn taut(joint: &TouchJoint) -> Option<LoopJoint> {
    let pairing = joint.touch.pairing().filter(|_| is_rope(joint) && !joint.is_reeved())?;
    let kind = LoopKind::Distance(pairing.reach);
    Some(LoopJoint { name: "rope".into(), kind, a: joint.a, b: joint.b })
}

impl Eventful {
    /// Takes a state at rest as one that may move: all that equations know may.
    fn wake(&mut self, state: &mut State) {
        if std::mem::take(&mut self.progress.asleep) {
            self.enter(state);
        }
    }

    /// The mechanism that moves in the mode of a state.
    fn moving(&self, whole: Mechanism, state: &State, efforts: &[f64]) -> Result<Moving, MovingError> {
        let piece = &self.workspaces.active();
        let mut held = piece.moving.clone();
        if held.mechanism.touches.iter().any(|touch| taut(touch).is_some()) {
            let mechanism = &mut Arc::make_mut(&mut held).mechanism;
            let ropes = mechanism.touches.iter().filter_map(taut);
            mechanism.loops.extend(ropes.collect::<Vec<_>>());
            mechanism.touches.retain(|touch| taut(touch).is_none());
        }
        let reeved = held.mechanism.touches.iter().filter(|touch| touch.is_reeved()).count();
        if reeved > 0 {
            return Err(MovingError::Reeved { count: reeved });
        }
        let unknown = |touch: &&TouchJoint| touch.moments != Moments::default() || touch.is_belt();
        let unknown = held.mechanism.touches.iter().filter(unknown).count();
        if unknown > 0 {
            return Err(MovingError::Contacts { count: unknown });
        }
        let mut of_whole = vec![0.0; whole.velocity_count];
        Inputs::constant(efforts).write_constant(&mut of_whole);
        self.mode.add_constant_efforts(&self.model.elements, &mut of_whole);
        let mut own = vec![0.0; held.mechanism.velocity_count];
        held.gather_velocities(&whole, &of_whole, &mut own);
        let joints = self.model.elements.joints.iter().zip(&self.mode.joints);
        let stuck = joints.filter_map(|(joint, mode)| match mode {
            JointMode::Free { .. } => None,
            JointMode::Held { on } => {
                Some(Stuck { joint: whole.bodies[joint.coordinate.body].joint.name.clone(), on: *on })
            }
        });
        let stuck = stuck.collect();
        let motors =
            self.model.elements.motors.iter().zip(&self.mode.motors).enumerate().map(|(number, (motor, mode))| {
                let saturated = matches!(mode, MotorMode::Saturated(_));
                Driving {
                    motor: number,
                    freedom: held.freedom(&whole, motor.coordinate.freedom),
                    by_target: if saturated { 0.0 } else { by_target(&motor.law) },
                    saturated,
                }
            });
        let motors = motors.collect();
        let sticks = |closed: &&Closed| self.mode.is_anchored(closed);
        let mut moving = Moving {
            state: held.gather(&whole, state),
            efforts: DVector::zeros(own.len()),
            constant: DVector::from_vec(own),
            drives: piece.drives.clone(),
            stuck,
            motors,
            sticking: self.mode.contacts.iter().filter(sticks).count(),
            held,
            whole: Arc::new(whole),
        };
        moving.efforts = moving.efforts_at(state.time, state.time);
        Ok(moving)
    }
}

/// The effort for each unit of a target that stays where it is.
fn by_target(law: &MotorLaw) -> f64 {
    match *law {
        MotorLaw::Position { kp, .. } => kp,
        MotorLaw::Velocity { kd } => kd,
        MotorLaw::Effort => 1.0,
    }
}

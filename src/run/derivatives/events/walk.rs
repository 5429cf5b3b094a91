//! The derivatives of a run along its trace: step by step, and through the jumps between them.
//!
//! ```text
//!     step to a given instant T(θ)       δh = δT − δt₀                     δt̄ = δT
//!     step to an event φ = 0             δh = −(φ_x δx̄ + φ_t δt₀ + φ_θ δθ)/φ̇        δt̄ = δt₀ + δh        δx̄ at fixed h
//!     jump                               δv⁺ = j_q δq + j_v δv + j_θ δθ
//! ```
//!
//! Steps, modes and active sets are those of the trace; states are solved again to rounding. Held joints keep the derivatives of their places: the
//! place at which a joint sticks is a function of the parameters.

use crate::derivatives::equations::closed::ClosedContacts;
use crate::derivatives::equations::figures::LoopFigures;
use crate::derivatives::events::efforts::{EffortLaws, Efforts};
use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::looks::Looks;
use crate::derivatives::events::parameter::{Parameter, TimeLaws};
use crate::derivatives::events::validity::{MetEvent, Validity};
use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::forward::stage_equations::BothFigures;
use crate::derivatives::forward::step::{Part, SolvedStep, StepMode, WIDTH, lifted};
use crate::derivatives::forward::tangent::{Tangent, Varied};
use crate::derivatives::linear::independent::Independent;
use crate::derivatives::numbers::number::Number;
use crate::events::trace::{Closed, Mode, MotorMode, Traced, TracedJump, TracedStep};
use crate::instant::holding::elements::Elements;
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};
use std::cell::OnceCell;
use std::sync::Arc;

/// A tick or an instant of a law is this close to its time, in parts of it.
pub(super) const AT_TICK: f64 = 1e-9;

/// Solved steps that end further than this from the steps of the run are other steps.
const MOST_DRIFT: f64 = 1e-6;

/// The model of a run whose derivatives are wanted.
pub(crate) struct Subject<'w> {
    pub mechanism: &'w Mechanism,
    pub elements: &'w Elements,
    /// The frames of the bodies, each in the body's own.
    pub frames: &'w [Pose],
    pub tableau: &'w Tableau,
    /// Two stages, for brief steps.
    pub brief: &'w Tableau,
    pub laws: &'w TimeLaws,
    pub parameters: &'w [Parameter],
    /// When the run ends (s).
    pub end: f64,
}

/// A point of a contact that sticks, with its derivatives for each [`WIDTH`] parameters.
type Anchored = (LoopFigures<f64>, Vec<LoopFigures<Part>>);

/// A solved step.
pub(super) struct KeptStep {
    /// h (s).
    pub step: f64,
    pub mode: StepMode,
    pub solved: SolvedStep,
    /// At all stages (n each).
    pub efforts: Vec<DVector<f64>>,
}

/// Derivatives along a run.
pub(crate) struct Walk<'w> {
    pub(super) subject: &'w Subject<'w>,
    pub(super) figures: BothFigures<f64>,
    pub(super) constant: BothFigures<Part>,
    pub(super) varied: Varied,
    /// Made when it is first asked for.
    pub(super) looks: OnceCell<Looks>,
    /// Where it is.
    pub state: State,
    pub tangent: Tangent,
    /// The derivatives at the end of the last step, at the time at which it is now, if that end moves.
    pub(super) still: Option<Tangent>,
    /// Of efforts that motors hold between ticks (motors × p).
    pub(super) given: DMatrix<f64>,
    /// When the run began (s).
    pub(super) began: f64,
    /// Whether a step was made.
    pub(super) begun: bool,
    /// The largest rate before a jump [rad/s or m/s].
    pub(super) fastest: f64,
    /// Points of contacts that stick, with their derivatives for each [`WIDTH`] parameters.
    pub(super) anchored: Vec<Anchored>,
    /// The most that a solved step ended from the step of the run (rad or m; or this part of larger positions).
    pub(super) drift: f64,
    /// The closed contacts of the last step.
    pub(super) entered: Vec<Closed>,
    /// Whether the last step is kept, and the step.
    pub(super) keeps: bool,
    pub(super) kept: Option<Arc<KeptStep>>,
    /// The next step, if it was solved before.
    pub(super) known: Option<Arc<KeptStep>>,
    /// Events so far, and how far the derivatives hold.
    pub events: Vec<MetEvent>,
    pub validity: Validity,
    /// Whether anyone asks how far they hold.
    pub tells: bool,
    /// What makes derivatives worse than their order.
    pub warnings: Vec<String>,
}

impl<'w> Walk<'w> {
    /// At the start of a run.
    pub fn new(subject: &'w Subject<'w>, start: &State) -> Self {
        let Subject { mechanism, elements, frames, parameters, .. } = *subject;
        let (n, p) = (mechanism.velocity_count, parameters.len());
        let slopes: Vec<Vec<f64>> = parameters.iter().map(|parameter| parameter.figures.clone()).collect();
        let column = |of: &dyn Fn(&Parameter) -> &DVector<f64>| {
            DMatrix::from_fn(n, p, |row, column| of(&parameters[column])[row])
        };
        Walk {
            subject,
            figures: BothFigures::taken(mechanism, elements, frames, |_, value| value),
            constant: BothFigures::taken(mechanism, elements, frames, |_, value| Part::of(value)),
            varied: Varied::new(mechanism, elements, frames, &slopes),
            looks: OnceCell::new(),
            state: start.clone(),
            tangent: Tangent {
                positions: column(&|parameter| &parameter.position),
                velocities: column(&|parameter| &parameter.velocity),
                times: DVector::zeros(p),
            },
            still: None,
            given: DMatrix::zeros(elements.motors.len(), p),
            began: start.time,
            begun: false,
            fastest: fastest(&start.velocity),
            anchored: Vec::new(),
            drift: 0.0,
            entered: Vec::new(),
            keeps: false,
            kept: None,
            known: None,
            events: Vec::new(),
            validity: Validity::new(p),
            tells: true,
            warnings: Vec::new(),
        }
    }

    /// Goes along a trace; `at` is called at the end of every step with the derivatives at its time, before it jumps, and whether the end moves.
    ///
    /// # Errors
    /// [`SensitivityError`] where a step or jump has no derivative.
    pub fn along(
        &mut self,
        trace: &[Traced],
        at: &mut dyn FnMut(&State, &Tangent, bool),
    ) -> Result<(), SensitivityError> {
        for (index, entry) in trace.iter().enumerate() {
            match entry {
                Traced::Step(step) => {
                    let next = trace[index + 1..].iter().find_map(|entry| match entry {
                        Traced::Jump(jump) => Some(&**jump),
                        Traced::Step(_) => None,
                    });
                    self.still = None;
                    self.step(step, next)?;
                    match self.still.take() {
                        Some(still) => at(&self.state, &still, true),
                        None => at(&self.state, &self.tangent, false),
                    }
                }
                Traced::Jump(jump) => self.jump(jump)?,
            }
        }
        Ok(())
    }

    pub(super) fn failed(&self) -> SensitivityError {
        SensitivityError::Step { time: self.state.time }
    }

    /// The efforts at some times (s) of a step that begins at another.
    pub(super) fn efforts_at(&self, mode: &Mode, since: f64, times: &[f64]) -> Vec<Efforts> {
        let Subject { elements, laws, parameters, .. } = *self.subject;
        let of = EffortLaws { elements, laws, parameters, varied: &self.varied };
        of.at(mode, &self.given, since, times, self.state.velocity.len())
    }

    /// The equations of a mode.
    pub(super) fn mode(&self, traced: &TracedStep) -> Result<StepMode, SensitivityError> {
        let Subject { mechanism, elements, .. } = *self.subject;
        let moves = mechanism.bodies.iter().zip(&traced.held).filter(|(_, held)| !**held);
        let free: Vec<usize> = moves.flat_map(|(body, _)| body.joint.velocity_range()).collect();
        let motors = elements.motors.iter().zip(&traced.mode.motors).enumerate();
        let motors = motors.filter(|(_, (_, mode))| **mode == MotorMode::Unbounded);
        let motors = motors.map(|(index, (motor, _))| (index, motor.coordinate)).collect();
        let anchors = self.anchors_of(traced);
        let constant = ClosedContacts {
            anchors: anchors.iter().map(lifted).collect(),
            touches: self.touches_of(traced, &self.constant.laws)?,
            shares: Vec::new(),
        };
        let touches = self.touches_of(traced, &self.figures.laws)?;
        let closed = ClosedContacts { anchors, touches, shares: Vec::new() };
        let slips = self.slips_of(traced);
        let mut mode = StepMode { free, rows: Vec::new(), row_count: 0, motors, closed, constant, slips };
        let gradient = self.gradient(&mode);
        mode.row_count = gradient.nrows();
        let mut of_free = gradient.select_columns(&mode.free);
        mode.take_shares(&mut of_free);
        mode.rows = Independent::of(&of_free, &vec![1.0; mode.free.len()]).rows;
        Ok(mode)
    }

    /// G of all closures at the state.
    pub(super) fn gradient(&self, mode: &StepMode) -> DMatrix<f64> {
        let n = self.state.velocity.len();
        let plain = &self.figures.plain;
        if plain.loops.is_empty() && plain.mimics.is_empty() && mode.closed.is_empty() {
            return DMatrix::zeros(0, n);
        }
        let still = vec![Part::zero(); n];
        let at = Instant { figures: &self.constant, state: &self.state, offsets: &still, closed: &mode.constant };
        let columns = (0..n).step_by(WIDTH).map(|first| {
            let mut units = still.clone();
            units.iter_mut().skip(first).take(WIDTH).enumerate().for_each(|(part, own)| own.parts[part] = 1.0);
            at.closure_rates(&units)
        });
        let columns: Vec<Vec<Part>> = columns.collect();
        let rows = columns.first().map_or(0, Vec::len);
        DMatrix::from_fn(rows, n, |row, column| columns[column / WIDTH][row].parts[column % WIDTH])
    }

    fn step(&mut self, traced: &TracedStep, next: Option<&TracedJump>) -> Result<(), SensitivityError> {
        let Subject { mechanism, .. } = *self.subject;
        if !self.begun {
            self.see_start(traced);
        }
        self.begin(traced);
        if self.drift > MOST_DRIFT {
            return Err(SensitivityError::Apart { apart: self.drift });
        }
        let since = self.state.time;
        self.meet_ticks(&traced.mode, since);
        for (body, _) in mechanism.bodies.iter().zip(&traced.held).filter(|(_, held)| **held) {
            body.joint.velocity_range().for_each(|freedom| self.tangent.velocities.row_mut(freedom).fill(0.0));
        }
        let known = self.known.take();
        let mode = known.as_ref().map_or_else(|| self.mode(traced), |known| Ok(known.mode.clone()))?;
        let mut closed = self.closed(traced, &mode)?;
        self.enter(traced, &mode, &closed)?;
        self.turn_directions(traced, &mode, &mut closed);
        if let Some(&trigger) = traced.triggers.first() {
            return self.step_to_event(traced, (&mode, known), &closed, trigger, next);
        }
        let later = self.later(traced, since)?;
        if mode.free.is_empty() {
            self.state.time = traced.end.time;
            self.still = later.iter().any(|by| *by != 0.0).then(|| self.tangent.clone());
            self.tangent.times = later;
            return Ok(());
        }
        self.see_shares(&mode);
        let (before, was) = (self.state.clone(), self.tangent.clone());
        let step = traced.end.time - since;
        let (kept, efforts) = match known {
            Some(known) => (known, self.efforts_over(traced, step)),
            None => {
                let (solved, efforts) = self.solved(traced, &mode, step, None)?;
                let values = efforts.iter().map(|efforts| efforts.values.clone()).collect();
                (Arc::new(KeptStep { step, mode, solved, efforts: values }), efforts)
            }
        };
        let (mode, solved) = (&kept.mode, &kept.solved);
        let longer = &later - &self.tangent.times;
        if later.iter().any(|by| *by != 0.0) {
            self.carry(mode, step, solved, efforts.clone(), &closed, &-&was.times)?;
            self.still = Some(std::mem::replace(&mut self.tangent, was.clone()));
        }
        self.carry(mode, step, solved, efforts, &closed, &longer)?;
        self.take_end(solved, traced.end.time);
        self.see_near(traced, (&before, &was), &solved.stages);
        self.kept = Some(kept).filter(|_| self.keeps);
        Ok(())
    }

    /// ∂T/∂θ of the end of a step to a given instant (p): the ticks of a motor move with its period, and the instants of its target with their times.
    /// The end of the run does not move.
    ///
    /// # Errors
    /// [`SensitivityError::Ticks`] where ticks of two motors fall together that move apart.
    pub(super) fn later(&self, traced: &TracedStep, since: f64) -> Result<DVector<f64>, SensitivityError> {
        let Subject { laws, parameters, end, .. } = *self.subject;
        let time = traced.end.time;
        let mut later = DVector::zeros(parameters.len());
        if time >= end {
            return Ok(later);
        }
        let here = |instant: f64| (instant - time).abs() <= AT_TICK * time.abs().max(1.0);
        let mut known = false;
        for (index, motor) in laws.motors.iter().enumerate().filter(|(_, motor)| here(motor.next_instant(since))) {
            let ticks = (time / motor.period).round();
            let piece = laws.piece(index, time);
            let instant = |laws: &TimeLaws| match motor.period > 0.0 {
                true => ticks * laws.motors[index].period,
                false => laws.beginning(index, piece),
            };
            let own = parameters.iter().map(|parameter| parameter.slope(instant));
            let own = DVector::from_iterator(parameters.len(), own);
            if known && (&own - &later).amax() > AT_TICK * own.amax().max(later.amax()) {
                return Err(SensitivityError::Ticks { time });
            }
            (known, later) = (true, own);
        }
        Ok(later)
    }
}

/// The largest of some rates.
pub(super) fn fastest(rates: &[f64]) -> f64 {
    rates.iter().fold(0.0, |most, rate| most.max(rate.abs()))
}

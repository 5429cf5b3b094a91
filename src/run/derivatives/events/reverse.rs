//! Gradients of a loss along a run, against time.
//!
//! ```text
//!     end of a step     λ̄ (δq̄, δv̄, δt̄)                R_uᵀ μ = λ̄        start: λ = −R_xᵀ μ        numbers: g −= R_θᵀ μ
//!     events, jumps     δx̄ = A δx + B δθ              λ = Aᵀ λ̄           g += Bᵀ λ̄         losses of the state at an event have A, B of its own
//! ```
//!
//! Steps of trees to given instants go back by their transpose, at a cost that does not depend on the number of parameters. Other pieces of a run, as
//! events with their jumps, have the matrices A and B of their forward derivatives. The tape keeps the trace of the run and one state every few
//! pieces. The states between are computed again, from the same numbers by the same arithmetic: a gradient does not depend on the states that are kept.
//!
//! Source: A. Griewank, A. Walther, Evaluating Derivatives, SIAM 2008, chapters 3 and 12.

use crate::derivatives::events::parameter::Parameter;
use crate::derivatives::events::validity::{MetEvent, Validity};
use crate::derivatives::events::walk::{KeptStep, Subject, Walk};
use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::forward::step::Factors;
use crate::derivatives::forward::tangent::Tangent;
use crate::derivatives::forward::tree::{FigureCotangents, pulled_back};
use crate::events::trace::{Closed, MotorMode, Traced, TracedStep};
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Room for steps that are kept solved (bytes).
const ROOM: usize = 256 << 20;

/// The derivatives of a loss by the state at an instant.
#[derive(Clone, Debug)]
pub(crate) struct Adjoint {
    /// The derivatives by q and v (n each); turns of ball joints are about the axes of the child.
    pub positions: DVector<f64>,
    pub velocities: DVector<f64>,
    /// The derivative by the time at which the state is reached.
    pub time: f64,
}

impl Adjoint {
    /// The sum of both.
    pub fn plus(&self, other: &Adjoint) -> Adjoint {
        Adjoint {
            positions: &self.positions + &other.positions,
            velocities: &self.velocities + &other.velocities,
            time: self.time + other.time,
        }
    }
}

/// The place of a walk without parameters.
#[derive(Clone)]
struct Place {
    state: State,
    fastest: f64,
    entered: Vec<Closed>,
}

impl Place {
    fn of(walk: &Walk) -> Self {
        Place { state: walk.state.clone(), fastest: walk.fastest, entered: walk.entered.clone() }
    }

    fn restore(&self, walk: &mut Walk) {
        walk.state = self.state.clone();
        (walk.fastest, walk.entered) = (self.fastest, self.entered.clone());
        walk.anchored.clear();
    }
}

/// A run on its tape.
pub(crate) struct Tape<'t> {
    subject: &'t Subject<'t>,
    walk: Walk<'t>,
    /// The trace of each piece of the run, up to where the integrator came back.
    pieces: Vec<Vec<Traced>>,
    /// The solved step of each piece, while there is room and every state is kept; the way back takes them.
    solved: Vec<Option<Arc<KeptStep>>>,
    room: usize,
    /// The number of events before each piece.
    first_events: Vec<usize>,
    /// The first place, and one for every so many pieces.
    kept: Vec<Place>,
    every: usize,
}

impl<'t> Tape<'t> {
    /// The empty tape of a run from a start on; `subject` has no parameters, and the state is kept once in `every` pieces.
    pub fn new(subject: &'t Subject<'t>, start: &State, every: usize) -> Self {
        let mut walk = Walk::new(subject, start);
        walk.tells = false;
        let (pieces, solved, first_events, kept) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Tape { subject, walk, pieces, solved, room: ROOM, first_events, kept, every: every.max(1) }
    }

    /// The state at the end.
    pub fn state(&self) -> &State {
        &self.walk.state
    }

    /// What makes derivatives worse than their order.
    pub fn warnings(&self) -> &[String] {
        &self.walk.warnings
    }

    /// The events so far.
    pub fn events(&self) -> &[MetEvent] {
        &self.walk.events
    }

    /// How far derivatives by some parameters hold at the start of the run.
    pub fn start_validity(&self, parameters: &[Parameter]) -> Validity {
        let local = Subject { parameters, ..*self.subject };
        let first = self.pieces.iter().flatten().find_map(step_of);
        let (Some(place), Some(step)) = (self.kept.first(), first) else { return Validity::new(parameters.len()) };
        let mut walk = Walk::new(&local, &place.state);
        walk.see_start(step);
        walk.validity
    }

    /// Adds a piece, and goes along it.
    ///
    /// # Errors
    /// [`SensitivityError`] for a piece without a derivative, or without one against time.
    pub fn add(&mut self, trace: Vec<Traced>) -> Result<(), SensitivityError> {
        if self.pieces.len().is_multiple_of(self.every) {
            self.kept.push(Place::of(&self.walk));
        }
        for step in trace.iter().filter_map(step_of) {
            let (part, advice) = if !step.closures.anchors.is_empty() {
                ("corners that stick, against time", "take forward derivatives, or end the run before it")
            } else if step.mode.motors.iter().any(|motor| matches!(motor, MotorMode::Given(_))) {
                ("motors that hold their effort between ticks, against time", "take forward derivatives")
            } else {
                continue;
            };
            return Err(SensitivityError::Unsupported { part, advice });
        }
        self.first_events.push(self.walk.events.len());
        self.walk.kept = None;
        self.walk.keeps = self.every == 1 && trace.iter().filter_map(step_of).count() == 1 && self.room > 0;
        self.walk.along(&trace, &mut |_, _, _| {})?;
        let solved = self.walk.kept.take();
        let rows = solved.as_ref().map_or(0, |step| step.mode.size(step.efforts.len()));
        self.room = self.room.saturating_sub(rows * rows * size_of::<f64>());
        self.solved.push(solved);
        self.pieces.push(trace);
        Ok(())
    }

    /// The derivatives of a loss by the parameters; `of_end` and `of_event` are what it says of the end of each piece and of each event, if anything.
    ///
    /// # Errors
    /// [`SensitivityError`] as along the run.
    pub fn gradient(
        &mut self,
        parameters: &[Parameter],
        of_end: &dyn Fn(usize) -> Option<Adjoint>,
        of_event: &dyn Fn(usize) -> Option<Adjoint>,
    ) -> Result<Vec<f64>, SensitivityError> {
        let Some(start) = self.kept.first().map(|place| place.state.clone()) else {
            return Ok(vec![0.0; parameters.len()]);
        };
        let n = start.velocity.len();
        let units = units(n, parameters);
        let local = Subject { parameters: &units, ..*self.subject };
        let mut walk = Walk::new(&local, &start);
        walk.tells = false;
        let mut back = Back {
            figures: FigureCotangents::zero(self.subject.mechanism.bodies.len(), walk.varied.slopes()),
            walk,
            freedoms: n,
            gradient: vec![0.0; parameters.len()],
            adjoint: Adjoint { positions: DVector::zeros(n), velocities: DVector::zeros(n), time: 0.0 },
        };
        for (block, place) in self.kept.iter().enumerate().rev() {
            let first = block * self.every;
            let pieces = &self.pieces[first..self.pieces.len().min(first + self.every)];
            place.restore(&mut self.walk);
            let mut places = Vec::with_capacity(pieces.len());
            for (index, piece) in pieces.iter().enumerate() {
                places.push(Place::of(&self.walk));
                if index + 1 < pieces.len() {
                    self.walk.along(piece, &mut |_, _, _| {})?;
                }
            }
            for (index, (piece, place)) in pieces.iter().zip(&places).enumerate().rev() {
                if let Some(said) = of_end(first + index) {
                    back.adjoint = back.adjoint.plus(&said);
                }
                let first_event = self.first_events[first + index];
                let solved = self.solved[first + index].take();
                back.over((piece, solved), place, &|own| of_event(first_event + own))?;
            }
        }
        let Back { walk, figures, mut gradient, adjoint, .. } = back;
        for (column, (own, parameter)) in gradient.iter_mut().zip(parameters).enumerate() {
            *own += adjoint.positions.dot(&parameter.position) + adjoint.velocities.dot(&parameter.velocity);
            if let Some(slopes) = &walk.varied.slopes()[2 * n + 1 + column] {
                *own += figures.by(slopes);
            }
        }
        Ok(gradient)
    }
}

fn step_of(entry: &Traced) -> Option<&TracedStep> {
    match entry {
        Traced::Step(step) => Some(step),
        Traced::Jump(_) => None,
    }
}

/// The state in all directions, then the parameters without their part in the start.
fn units(freedoms: usize, parameters: &[Parameter]) -> Vec<Parameter> {
    let states = (0..2 * freedoms + 1).map(|which| {
        let mut unit = Parameter::none(freedoms);
        if which < freedoms {
            unit.position[which] = 1.0;
        } else if which < 2 * freedoms {
            unit.velocity[which - freedoms] = 1.0;
        }
        unit
    });
    let zero = DVector::zeros(freedoms);
    let own = parameters.iter().map(|parameter| Parameter {
        position: zero.clone(),
        velocity: zero.clone(),
        ..parameter.clone()
    });
    states.chain(own).collect()
}

/// On the way back.
struct Back<'b> {
    /// Its first parameters are the state: q, v and the time.
    walk: Walk<'b>,
    freedoms: usize,
    figures: FigureCotangents,
    gradient: Vec<f64>,
    adjoint: Adjoint,
}

impl Back<'_> {
    fn over(
        &mut self,
        (piece, solved): (&[Traced], Option<Arc<KeptStep>>),
        place: &Place,
        of_event: &dyn Fn(usize) -> Option<Adjoint>,
    ) -> Result<(), SensitivityError> {
        place.restore(&mut self.walk);
        if let [Traced::Step(step)] = piece
            && step.triggers.is_empty()
            && step.mode.contacts.is_empty()
            && self.over_step(step, &solved)?
        {
            return Ok(());
        }
        self.walk.known = solved;
        self.over_matrices(piece, of_event)
    }

    /// Over a piece by its forward derivatives.
    fn over_matrices(
        &mut self,
        piece: &[Traced],
        of_event: &dyn Fn(usize) -> Option<Adjoint>,
    ) -> Result<(), SensitivityError> {
        let (n, p) = (self.freedoms, self.gradient.len());
        let all = 2 * n + 1 + p;
        let mut tangent = Tangent {
            positions: DMatrix::zeros(n, all),
            velocities: DMatrix::zeros(n, all),
            times: DVector::zeros(all),
        };
        for row in 0..n {
            tangent.positions[(row, row)] = 1.0;
            tangent.velocities[(row, n + row)] = 1.0;
        }
        tangent.times[2 * n] = 1.0;
        self.walk.tangent = tangent;
        self.walk.validity = Validity::new(all);
        self.walk.events.clear();
        self.walk.along(piece, &mut |_, _, _| {})?;
        let pulled_back = |tangent: &Tangent, by: &Adjoint| {
            tangent.positions.tr_mul(&by.positions)
                + tangent.velocities.tr_mul(&by.velocities)
                + &tangent.times * by.time
        };
        let mut pulled = pulled_back(&self.walk.tangent, &self.adjoint);
        for (index, event) in self.walk.events.iter().enumerate() {
            if let Some(said) = of_event(index) {
                pulled += pulled_back(&event.tangent, &said);
            }
        }
        self.adjoint = Adjoint {
            positions: pulled.rows(0, n).into_owned(),
            velocities: pulled.rows(n, n).into_owned(),
            time: pulled[2 * n],
        };
        self.gradient.iter_mut().zip(pulled.iter().skip(2 * n + 1)).for_each(|(own, by)| *own += by);
        Ok(())
    }

    /// Over a step of a tree to a given instant by its transpose; false if it is none.
    fn over_step(&mut self, traced: &TracedStep, solved: &Option<Arc<KeptStep>>) -> Result<bool, SensitivityError> {
        let (n, p) = (self.freedoms, self.gradient.len());
        self.walk.begin(traced);
        let since = self.walk.state.time;
        let step = traced.end.time - since;
        let kept = match solved {
            Some(kept) => kept.clone(),
            None => {
                let mode = self.walk.mode(traced)?;
                if mode.free.is_empty() {
                    return Ok(false);
                }
                let (solved, efforts) = self.walk.solved(traced, &mode, step, None)?;
                let efforts = efforts.into_iter().map(|efforts| efforts.values).collect();
                Arc::new(KeptStep { step, mode, solved, efforts })
            }
        };
        let KeptStep { mode, solved, efforts: values, .. } = &*kept;
        let Factors::Tree(factors) = &solved.factors else { return Ok(false) };
        let nodes = &self.walk.tableau(values.len()).nodes;
        let efforts = self.walk.efforts_over(traced, step);
        let problem = self.walk.problem(mode, step, values);
        let Adjoint { positions: of_q, velocities: of_v, time } = &self.adjoint;
        let pulled = pulled_back(&problem, solved, factors, [of_q, of_v], &mut self.figures, self.walk.varied.slopes())
            .ok_or_else(|| self.walk.failed())?;
        let later = self.walk.later(traced, since)?;
        let (mut longer, mut of_time) = (pulled.given.longer, 0.0);
        for (stage, of_efforts) in pulled.given.efforts.iter().enumerate() {
            for (freedom, by) in of_efforts.iter().enumerate() {
                let by_time = by * efforts[stage].rates[freedom];
                of_time += by_time;
                longer += by_time * nodes[stage];
                if *by != 0.0 {
                    for column in 0..p {
                        self.gradient[column] += by * efforts[stage].slopes[(freedom, 2 * n + 1 + column)];
                    }
                }
            }
        }
        for column in 0..p {
            let all = 2 * n + 1 + column;
            self.gradient[column] += pulled.laws[all] + later[all] * (*time + longer);
        }
        let positions = DVector::from_vec(pulled.given.positions);
        let velocities = DVector::from_vec(pulled.given.velocities);
        self.adjoint = Adjoint { positions, velocities, time: of_time - longer };
        Ok(true)
    }
}

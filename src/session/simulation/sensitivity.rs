//! Derivatives of a run by its start, its efforts, and all numbers that have a key path.
//!
//! ```text
//!     run ─ times of its steps ─▶ the same steps, solved to rounding ─▶ R_u, R_x ─▶ ∂q/∂θ, ∂v/∂θ at the end of every step
//! ```
//!
//! Numbers of a scene reach the equations through the reader of files. The derivatives of masses, frames, springs and starts by such a number come
//! from eight models with other numbers, by differences of order eight: these functions are smooth and short, and the error is some 1e-13 of the
//! derivative. From there on everything is exact.
//!
//! Source: B. Fornberg, Generation of finite difference formulas on arbitrarily spaced grids, Math. Comp. 51 (1988), table 1.

use crate::derivatives::equations::figures::Figures;
use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::forward::stage_equations::BothFigures;
use crate::derivatives::forward::step::{Part, StepProblem};
use crate::derivatives::forward::tangent::{Tangent, Varied};
use crate::derivatives::numbers::number::Number;
use crate::events::Moving;
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::joint::{FreeRotation, Pose, rotation_from_wxyz};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::state::State;
use crate::session::error::Error;
use crate::session::linear::freedom_name;
use crate::session::model::Model;
use crate::session::simulation::Simulation;
use crate::simulation::{Observer, ObserverError, Sample, StepEnd};
use nalgebra::{DMatrix, DVector, Rotation3};
use std::sync::{Arc, Mutex};

/// Numbers vary by this part of themselves, and up to four times of it; numbers that are zero by this much.
const WIDTH: f64 = 4e-3;
/// Weights of the differences over k widths, k = 1..4.
const WEIGHTS: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// The repeated steps end this close to the run, in multiples of its tolerance and of its displacements.
const SAME: f64 = 1e-6;

/// The derivatives of a run at its start and at the end of every step.
#[derive(Clone, Debug)]
pub struct Sensitivity {
    /// The parameters θ (p).
    pub keys: Vec<String>,
    /// The degrees of freedom (n): joints, or `JOINT.x` for one of several.
    pub freedoms: Vec<String>,
    /// Times (s).
    pub times: Vec<f64>,
    /// q and v at these times.
    pub q: Vec<Vec<f64>>,
    /// v.
    pub v: Vec<Vec<f64>>,
    /// ∂q/∂θ (n × p) at these times; turns of ball joints are about the axes of the child.
    pub dq: Vec<DMatrix<f64>>,
    /// ∂v/∂θ (n × p), of the velocities along the freedoms.
    pub dv: Vec<DMatrix<f64>>,
    /// How far the repeated steps end from the run (rad or m).
    pub apart: f64,
}

/// The times of the steps of a run, and its first event.
#[derive(Clone, Default)]
struct Steps(Arc<Mutex<(Vec<f64>, Option<f64>)>>);

impl Observer for Steps {
    fn sample(&mut self, _sample: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }

    fn begin_again(
        &mut self,
        _method: &crate::mechanism::motion::integrator::MethodDescription,
    ) -> Result<(), ObserverError> {
        self.with(|(times, event)| {
            times.clear();
            *event = None;
        });
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        self.with(|(times, _)| times.push(end.time));
    }

    fn event(&mut self, event: &Event) {
        self.with(|(_, first)| {
            first.get_or_insert(event.time);
        });
    }

    fn skips_samples(&self) -> bool {
        true
    }
}

impl Steps {
    fn with<R>(&self, work: impl FnOnce(&mut (Vec<f64>, Option<f64>)) -> R) -> R {
        work(&mut self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }
}

/// One parameter: the derivatives of figures and start by it, and the efforts of models that have other values of it.
struct Parameter {
    figures: Vec<f64>,
    position: DVector<f64>,
    velocity: DVector<f64>,
    constant_effort: DVector<f64>,
    /// With their weights.
    others: Vec<(f64, Moving)>,
}

impl Simulation {
    /// Makes the run to its end, and computes the derivatives of its q and v by parameters: `start.q` and `start.v` (all freedoms, or
    /// `start.q.JOINT`), `effort.JOINT` (a constant effort), and key paths of [`Model::params`], masses, lengths, springs, gains and targets among
    /// them. The derivative is exact for the steps of the run.
    ///
    /// ```
    /// use catena::prelude::*;
    ///
    /// let model = Model::load("robots/double_pendulum.urdf")?;
    /// let run = Simulation::new(&model).duration(0.5).sensitivity(&["start.q.shoulder", "lower_arm.mass"])?;
    /// assert_eq!(run.dq.last().map(|last| last.shape()), Some((2, 2)));
    /// # Ok::<(), catena::session::Error>(())
    /// ```
    ///
    /// # Errors
    /// Unknown parameters; runs with events, loops or contacts, which have no derivatives yet; and errors of the run.
    pub fn sensitivity(mut self, keys: &[&str]) -> Result<Sensitivity, Error> {
        let start = self.look(State::clone)?;
        let model = self.model.clone();
        let mechanism = &model.description().mechanism;
        let moving = moving(mechanism, &start)?;
        let names: Vec<String> =
            (0..mechanism.velocity_count).map(|freedom| freedom_name(mechanism, freedom)).collect();
        let mut parameters = Vec::new();
        let mut told = Vec::new();
        for key in keys {
            for (name, parameter) in self.parameters(key, &names, &start)? {
                told.push(name);
                parameters.push(parameter);
            }
        }
        // The times of steps are figures.
        self.figures = true;
        let steps = Steps::default();
        self.observers.push(Box::new(steps.clone()));
        self.run()?;
        let end = self.look(State::clone)?;
        let stages = self.finish()?.method.stages;
        let (times, event) = steps.with(std::mem::take);
        if let Some(time) = event {
            return Err(SensitivityError::Event { time }.into());
        }
        let tableau = Tableau::of(stages).map_err(|_| SensitivityError::Step { time: start.time })?;
        let found = follow(&model, moving, &start, &times, tableau, &parameters)?;
        let last = found.states.last().unwrap_or(&start);
        let apart = last.position.iter().zip(&end.position).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        let size = end.position.iter().fold(1.0, |size: f64, position| size.max(position.abs()));
        if apart.is_nan() || apart > SAME * size {
            return Err(SensitivityError::Apart { apart }.into());
        }
        let (q, v) = found.states.iter().map(|state| model.flat(state)).unzip();
        let times = found.states.iter().map(|state| state.time).collect();
        let (dq, dv) = found.tangents.into_iter().map(|tangent| (tangent.positions, tangent.velocities)).unzip();
        Ok(Sensitivity { keys: told, freedoms: names, times, q, v, dq, dv, apart })
    }

    /// The parameters of a key, with their names.
    fn parameters(&self, key: &str, names: &[String], start: &State) -> Result<Vec<(String, Parameter)>, Error> {
        let n = names.len();
        let known = [("start.q", 0), ("start.v", 1), ("effort", 2)];
        let of = known.iter().find_map(|(word, of)| {
            let rest = key.strip_prefix(word)?;
            (rest.is_empty() && *of < 2 || rest.starts_with('.')).then_some((*of, *word, rest.trim_start_matches('.')))
        });
        let Some((of, word, joint)) = of else { return Ok(vec![(key.to_string(), self.by_number(key, start)?)]) };
        let belongs = |name: &str| {
            joint.is_empty() || name == joint || name.strip_prefix(joint).is_some_and(|axis| axis.starts_with('.'))
        };
        let freedoms: Vec<usize> = (0..n).filter(|&freedom| belongs(&names[freedom])).collect();
        if freedoms.is_empty() {
            return Err(SensitivityError::Unknown { key: key.to_string() }.into());
        }
        let unit = |freedom: usize, which: usize| {
            let vector = |own: usize| DVector::from_fn(n, |row, _| f64::from(u8::from(own == which && row == freedom)));
            let (position, velocity, constant_effort) = (vector(0), vector(1), vector(2));
            Parameter { figures: Vec::new(), position, velocity, constant_effort, others: Vec::new() }
        };
        Ok(freedoms.into_iter().map(|freedom| (format!("{word}.{}", names[freedom]), unit(freedom, of))).collect())
    }

    /// The parameter of a number by its key path.
    fn by_number(&self, key: &str, start: &State) -> Result<Parameter, Error> {
        let own = || key.to_string();
        let params = self.model.params()?;
        let matches = |name: &str| name == key || name.strip_suffix(key).is_some_and(|before| before.ends_with('.'));
        let mut found = params.iter().filter(|(name, _)| matches(name));
        let exact = params.iter().find(|(name, _)| name == key);
        let (_, value) = exact.or_else(|| found.next()).ok_or_else(|| SensitivityError::Unknown { key: own() })?;
        let value = value.ok_or_else(|| SensitivityError::NoValue { key: own() })?;
        let width = if value == 0.0 { WIDTH } else { WIDTH * value.abs() };
        let n = start.velocity.len();
        let here = figures_of_moving(&self.model, &moving(&self.model.description().mechanism, start)?);
        let mut parameter = Parameter {
            figures: vec![0.0; here.len()],
            position: DVector::zeros(n),
            velocity: DVector::zeros(n),
            constant_effort: DVector::zeros(n),
            others: Vec::new(),
        };
        for (index, weight) in WEIGHTS.iter().enumerate() {
            for sign in [1.0, -1.0] {
                let other = value + sign * (index + 1) as f64 * width;
                let weight = sign * weight / width;
                let edge = |reason: String| SensitivityError::Edge { key: own(), value, other, reason };
                let model = self.model.with_params([(key, other)]).map_err(|error| edge(error.to_string()))?;
                let begun = model
                    .loaded()
                    .assembled(&self.positions, &self.velocities, None)
                    .map_err(|error| edge(error.to_string()))?;
                let mut state = begun.state;
                state.time = start.time;
                let moving = moving(&model.description().mechanism, &state)?;
                let figures = figures_of_moving(&model, &moving);
                if figures.len() != here.len() || state.position.len() != start.position.len() {
                    return Err(SensitivityError::Structure { key: own(), value }.into());
                }
                parameter.figures.iter_mut().zip(&figures).for_each(|(slope, figure)| *slope += weight * figure);
                let mechanism = &self.model.description().mechanism;
                parameter.position += weight * motion_between(mechanism, start, &state);
                parameter.velocity += weight * DVector::from_column_slice(&state.velocity);
                parameter.others.push((weight, moving));
            }
        }
        Ok(parameter)
    }
}

/// The mechanism that moves at the start of a run whose derivatives are known.
fn moving(mechanism: &Mechanism, start: &State) -> Result<Moving, SensitivityError> {
    let refuse = |part, advice| Err(SensitivityError::Unsupported { part, advice });
    if !mechanism.loops.is_empty() || !mechanism.mimics.is_empty() {
        return refuse("loops and mimic relations", "leave them out, or compare runs with other numbers");
    }
    if mechanism.nonsmooth.motors.iter().any(|motor| motor.period > 0.0) {
        return refuse("sampled motors", "set their period to zero");
    }
    let balls = |freedom: usize| {
        let body = mechanism.body_of_freedom(freedom).map(|body| &mechanism.bodies[body].joint);
        body.is_some_and(|joint| {
            joint.kind.rotation() == FreeRotation::Ball
                && freedom >= joint.velocity_index + joint.kind.translation_axes().len()
        })
    };
    if mechanism.forces.joint_dampers.iter().any(|damper| balls(damper.freedom)) {
        return refuse("dampers in ball joints", "leave damping out with --without damping");
    }
    let moving = Moving::at(mechanism, start, &[])?;
    if !moving.stuck.is_empty() || moving.sticking > 0 {
        return refuse(
            "stuck joints and closed contacts",
            "start in a motion, or leave friction, limits and contact out",
        );
    }
    Ok(moving)
}

/// The frames of the links that head the bodies, each in the frame of its body.
fn frames(model: &Model) -> Vec<Pose> {
    let description = model.description();
    let of = |(index, body): (usize, &crate::mechanism::description::mechanism::Body)| {
        let head = description.links.iter().find(|link| link.body == Some(index) && link.name == body.name);
        head.map_or_else(Pose::identity, |link| link.in_body)
    };
    description.mechanism.bodies.iter().enumerate().map(of).collect()
}

fn figures_of_moving(model: &Model, moving: &Moving) -> Vec<f64> {
    listed(moving.mechanism(), &frames(model))
}

/// All figures of a mechanism, in their order.
fn listed(mechanism: &Mechanism, frames: &[Pose]) -> Vec<f64> {
    let mut all = Vec::new();
    let _: Figures<f64> = Figures::taken(mechanism, frames, &mut |value| {
        all.push(value);
        value
    });
    all
}

/// The motion from one state to another (n): turns of ball joints as rotation vectors about the axes of the child.
fn motion_between(mechanism: &Mechanism, from: &State, to: &State) -> DVector<f64> {
    let mut motion = DVector::zeros(mechanism.velocity_count);
    for body in &mechanism.bodies {
        let joint = &body.joint;
        let slides = joint.kind.translation_axes().len();
        let is_ball = joint.kind.rotation() == FreeRotation::Ball;
        let scalars = if is_ball { slides } else { joint.kind.velocity_count() };
        for offset in 0..scalars {
            let slot = joint.position_index + offset;
            motion[joint.velocity_index + offset] =
                (to.position[slot] - from.position[slot]) + (to.compensation[slot] - from.compensation[slot]);
        }
        if is_ball {
            let slot = joint.position_index + slides;
            let [from, to] = [from, to].map(|state| rotation_from_wxyz(&state.position[slot..slot + 4]));
            let turn = Rotation3::from_matrix_unchecked(from.transpose() * to).scaled_axis();
            motion.rows_mut(joint.velocity_index + slides, 3).copy_from(&turn);
        }
    }
    motion
}

/// The states and tangents of a run that is followed.
struct Followed {
    states: Vec<State>,
    tangents: Vec<Tangent>,
}

/// Makes the steps of a run again, solved to rounding, with their derivatives.
fn follow(
    model: &Model,
    mut moving: Moving,
    start: &State,
    times: &[f64],
    tableau: &Tableau,
    parameters: &[Parameter],
) -> Result<Followed, SensitivityError> {
    let mechanism = moving.mechanism().clone();
    let frames = frames(model);
    let (n, p) = (mechanism.velocity_count, parameters.len());
    let figures = BothFigures::taken(&mechanism, &frames, |_, value| value);
    let constant: BothFigures<Part> = BothFigures::taken(&mechanism, &frames, |_, value| Part::of(value));
    let slopes: Vec<Vec<f64>> = parameters.iter().map(|parameter| parameter.figures.clone()).collect();
    let varied = Varied::new(&mechanism, &frames, &slopes);
    let column = |of: &dyn Fn(&Parameter) -> DVector<f64>| {
        let columns: Vec<DVector<f64>> = parameters.iter().map(of).collect();
        DMatrix::from_fn(n, p, |row, column| columns[column][row])
    };
    let mut tangent = Tangent {
        positions: column(&|parameter| parameter.position.clone()),
        velocities: column(&|parameter| parameter.velocity.clone()),
    };
    let mut others: Vec<Vec<(f64, Moving)>> = parameters.iter().map(|parameter| parameter.others.clone()).collect();
    let mut state = start.clone();
    let mut found = Followed { states: vec![state.clone()], tangents: vec![tangent.clone()] };
    for &time in times.iter().filter(|&&time| time > start.time) {
        let since = state.time;
        let step = time - since;
        let at = |node: &f64| since + step * node;
        let efforts: Vec<DVector<f64>> = tableau.nodes.iter().map(|node| moving.efforts_at(since, at(node))).collect();
        let slopes: Vec<DMatrix<f64>> = (tableau.nodes.iter())
            .map(|node| {
                let mut slopes = column(&|parameter| parameter.constant_effort.clone());
                for (column, others) in others.iter_mut().enumerate() {
                    for (weight, other) in others {
                        let mut own = slopes.column_mut(column);
                        own += *weight * other.efforts_at(since, at(node));
                    }
                }
                slopes
            })
            .collect();
        let problem = StepProblem {
            mechanism: &mechanism,
            figures: &figures,
            constant: &constant,
            tableau,
            start: &state,
            step,
            efforts: &efforts,
        };
        let failed = SensitivityError::Step { time: since };
        let Some(solved) = problem.solve() else { return Err(failed) };
        if tangent.advance(&problem, &solved, &varied, &slopes).is_none() {
            return Err(failed);
        }
        let Some(end) = solved.stages.last() else { return Err(failed) };
        let mut end = end.clone();
        end.time = time;
        state = end;
        found.states.push(state.clone());
        found.tangents.push(tangent.clone());
    }
    Ok(found)
}

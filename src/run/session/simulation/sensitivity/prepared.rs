//! A run that is made once for its steps, and then again with its trace.
//!
//! The steps of the run are repeated to the instants at which they ended, and at instants that are asked for. A step much shorter than the one after it
//! is made together with that one.

use crate::derivatives::events::parameter::{Parameter, TimeLaws};
use crate::derivatives::events::walk::Subject;
use crate::derivatives::forward::failure::SensitivityError;
use crate::events::trace::{TraceError, Traced, TracedRun};
use crate::instant::holding::elements::Elements;
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::state::State;
use crate::session::between_ticks::hold;
use crate::session::error::Error;
use crate::session::held_start::motors_from;
use crate::session::linear::freedom_name;
use crate::session::model::Model;
use crate::session::simulation::Simulation;
use crate::session::simulation::sensitivity::parameters::frames;
use crate::session::simulation::sensitivity::unknown::refuse;
use crate::simulation::{Observer, ObserverError, Sample, StepEnd};
use nalgebra::DMatrix;
use std::sync::{Arc, Mutex};

/// The repeated steps end this close to the run, in multiples of its tolerance and of its displacements.
const SAME: f64 = 1e-6;
/// A step shorter than this part of the way to the next instant is made together with the next one: derivatives over a step have roundings of 1e-16
/// over its length.
const SHORT: f64 = 0.1;

/// Steps that end this close to an event (s, or this part of a later time) end at it, or a moment before: a repeated step that is told to end there
/// has no event, and its end would not move.
const BESIDE: f64 = 1e-6;

/// Whether the end of a step is beside another instant.
pub(super) fn are_beside(instant: f64, time: f64) -> bool {
    (instant - time).abs() <= BESIDE * time.abs().max(1.0)
}

/// The times of the steps of a run, and of its events (s).
#[derive(Clone, Default)]
struct Steps(Arc<Mutex<[Vec<f64>; 2]>>);

impl Observer for Steps {
    fn sample(&mut self, _sample: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }

    fn begin_again(
        &mut self,
        _method: &crate::mechanism::motion::integrator::MethodDescription,
    ) -> Result<(), ObserverError> {
        self.with(|times| times.iter_mut().for_each(Vec::clear));
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        self.with(|[steps, _]| steps.push(end.time));
    }

    fn event(&mut self, event: &Event) {
        self.with(|[_, events]| events.push(event.time));
    }

    fn skips_samples(&self) -> bool {
        true
    }
}

impl Steps {
    fn with<R>(&self, work: impl FnOnce(&mut [Vec<f64>; 2]) -> R) -> R {
        work(&mut self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    /// The ends of steps that are not beside events, and the end of the run; and the events (s).
    fn instants(&self, start: f64, end: f64) -> [Vec<f64>; 2] {
        let [steps, events] = self.with(std::mem::take);
        let near = |time: f64| events.iter().any(|event| are_beside(*event, time));
        let given = steps.into_iter().filter(|time| *time > start && *time < end && !near(*time));
        [given.chain([end]).collect(), events]
    }
}

/// A run before it is differentiated.
pub(super) struct Prepared {
    pub model: Model,
    /// The mechanism of the run: targets and gains that motors take from the start are numbers of it.
    mechanism: Mechanism,
    pub start: State,
    /// The degrees of freedom (n), and the parameters (p) by their names.
    pub names: Vec<String>,
    pub told: Vec<String>,
    pub parameters: Vec<Parameter>,
    elements: Elements,
    frames: Vec<Pose>,
    laws: TimeLaws,
    tableau: &'static Tableau,
    brief: &'static Tableau,
    end: State,
    /// Ends of steps in order of time (s), and whether each was asked for.
    instants: Vec<(f64, bool)>,
    /// Instants that were asked for and are beside events of the run: no steps end there (s).
    pub beside: Vec<f64>,
}

impl Prepared {
    /// Makes a run to its end; its steps are to end at some times as well (s).
    pub fn new(mut simulation: Simulation, keys: &[&str], times: &[f64]) -> Result<Self, Error> {
        let start = simulation.look(State::clone)?;
        let model = simulation.model.clone();
        let mut mechanism = model.description().mechanism.clone();
        if let Some(motors) = motors_from(model.description(), &start, &simulation.held_at) {
            mechanism.nonsmooth.motors = motors;
        }
        hold(&mut mechanism.nonsmooth.motors, &simulation.held, start.time);
        refuse(&mechanism)?;
        let names: Vec<String> =
            (0..mechanism.velocity_count).map(|freedom| freedom_name(&mechanism, freedom)).collect();
        let (mut parameters, mut told, mut numbers) = (Vec::new(), Vec::new(), None);
        for key in keys {
            for (name, parameter) in simulation.parameters(key, &names, &start, &mut numbers)? {
                told.push(name);
                parameters.push(parameter);
            }
        }
        // The times of steps are figures.
        simulation.figures = true;
        let steps = Steps::default();
        simulation.observers.push(Box::new(steps.clone()));
        simulation.run()?;
        let end = simulation.look(State::clone)?;
        let stages = simulation.finish()?.method.stages;
        if let Some(&time) = times.iter().find(|time| !(**time >= start.time && **time <= end.time)) {
            return Err(SensitivityError::Sample { time, start: start.time, end: end.time }.into());
        }
        let asked = |time: f64| times.iter().any(|asked| are_beside(*asked, time));
        let [given, events] = steps.instants(start.time, end.time);
        let given = given.into_iter().filter(|time| *time == end.time || !asked(*time));
        let mut instants: Vec<(f64, bool)> = given.map(|time| (time, false)).collect();
        // Derivatives over the short steps between instants and events beside them have roundings as large as themselves.
        let near = |time: f64| events.iter().any(|event| are_beside(*event, time));
        let asked = times.iter().copied().filter(|time| *time > start.time);
        let (beside, ends): (Vec<f64>, Vec<f64>) = asked.partition(|time| near(*time));
        instants.extend(ends.into_iter().map(|time| (time, true)));
        instants.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let of = |stages: usize| Tableau::of(stages).map_err(|_| SensitivityError::Step { time: start.time });
        let (tableau, brief) = (of(stages)?, of(2)?);
        let elements = Elements::new(&mechanism);
        Ok(Prepared {
            frames: frames(&model),
            laws: TimeLaws::new(&elements.motors, &mechanism.forces),
            mechanism,
            elements,
            tableau,
            brief,
            end,
            beside,
            instants,
            start,
            names,
            told,
            parameters,
            model,
        })
    }

    /// The subject of the derivatives, by some parameters.
    pub fn subject<'p>(&'p self, parameters: &'p [Parameter]) -> Subject<'p> {
        Subject {
            mechanism: &self.mechanism,
            elements: &self.elements,
            frames: &self.frames,
            tableau: self.tableau,
            brief: self.brief,
            laws: &self.laws,
            parameters,
            end: self.end.time,
        }
    }

    /// The derivatives of the origins of the links of floating joints in their bodies (n × p).
    pub fn arms(&self) -> DMatrix<f64> {
        let (n, p) = (self.start.velocity.len(), self.parameters.len());
        DMatrix::from_fn(n, p, |row, column| self.parameters[column].arms[row])
    }

    /// A state as it is a moment later or earlier.
    pub fn moved_on(&self, state: &State, time: f64) -> State {
        let mut there = state.clone();
        let moved: Vec<f64> = state.velocity.iter().map(|rate| rate * (time - state.time)).collect();
        there.displace(&self.mechanism, &moved);
        there.time = time;
        there
    }

    /// The same run with its trace.
    pub fn traced(&self) -> Result<TracedRun, SensitivityError> {
        let longest = 2.0 * (self.end.time - self.start.time).max(1.0);
        TracedRun::new(&self.mechanism, self.tableau.stages, longest)
            .map_err(|_| SensitivityError::Step { time: self.start.time })
    }

    /// The instant to which the next step goes (s); `None` at the end.
    pub fn until(&self, time: f64) -> Option<f64> {
        if time >= self.end.time {
            return None;
        }
        let ahead = &self.instants[self.instants.partition_point(|(instant, _)| *instant <= time)..];
        let &(next, is_asked) = ahead.first()?;
        let is_short = |after: f64| next - time < SHORT * (after - time);
        let together = ahead.get(1).map(|(after, _)| *after).filter(|&after| !is_asked && is_short(after));
        Some(together.unwrap_or(next))
    }

    /// Makes a step of the traced run towards an instant.
    pub fn step(&self, run: &mut TracedRun, state: &mut State, until: f64) -> Result<Vec<Traced>, SensitivityError> {
        let time = state.time;
        run.step(state, until).map_err(|error| match error {
            TraceError::FirstOrder { time } => SensitivityError::FirstOrder { time },
            TraceError::Step(_) | TraceError::Method(_) => SensitivityError::Step { time },
        })
    }

    /// How far the repeated steps end from the run (rad or m).
    ///
    /// # Errors
    /// [`SensitivityError::Apart`] if that is more than their errors.
    pub fn check(&self, last: &State) -> Result<f64, SensitivityError> {
        let pairs = last.position.iter().zip(&self.end.position);
        let apart = pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        let size = self.end.position.iter().fold(1.0, |size: f64, position| size.max(position.abs()));
        if apart.is_nan() || apart > SAME * size {
            return Err(SensitivityError::Apart { apart });
        }
        Ok(apart)
    }
}

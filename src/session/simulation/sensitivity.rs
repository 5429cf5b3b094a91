//! Derivatives of a run by its start, its efforts, and all numbers that have a key path.
//!
//! ```text
//!     run ─ times of its steps ─▶ the same steps with their modes and jumps ─▶ solved to rounding ─▶ ∂q/∂θ, ∂v/∂θ at the ends of steps
//! ```
//!
//! From the derivatives of the start and of constant numbers on ([`parameters`]) everything is exact. A step much shorter than the one after it is made together with that one.

use crate::derivatives::events::parameter::TimeLaws;
use crate::derivatives::events::validity::EventSlope;
use crate::derivatives::events::walk::{Subject, Walk};
use crate::derivatives::forward::failure::SensitivityError;
use crate::events::trace::{TraceError, TracedRun};
use crate::instant::holding::elements::Elements;
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::joint::FreeRotation;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::state::State;
use crate::session::error::Error;
use crate::session::linear::freedom_name;
use crate::session::simulation::Simulation;
use crate::simulation::{Observer, ObserverError, Sample, StepEnd};
use nalgebra::{DMatrix, Vector3};
use std::sync::{Arc, Mutex};

mod parameters;

use parameters::frames;

/// The repeated steps end this close to the run, in multiples of its tolerance and of its displacements.
const SAME: f64 = 1e-6;
/// A step shorter than this part of the way to the next instant is made together with the next one: derivatives over a step have roundings of 1e-16
/// over its length.
const SHORT: f64 = 0.1;

/// The derivatives of a run at its start and at the end of every step to a given instant.
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
    /// The events of the run with the derivatives of their times.
    pub events: Vec<EventSlope>,
    /// How far each parameter may change before an event is missed, added, or comes in another order (p), to first order; infinite without events.
    pub valid_within: Vec<f64>,
    /// The event that bounds it, in words (p).
    pub bounded_by: Vec<String>,
    /// How far the repeated steps end from the run (rad or m).
    pub apart: f64,
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

    /// The ends of steps that are no events, and the end of the run (s).
    fn instants(&self, start: f64, end: f64) -> Vec<f64> {
        let [steps, events] = self.with(std::mem::take);
        let given = steps.into_iter().filter(|time| *time > start && *time < end && !events.contains(time));
        given.chain([end]).collect()
    }
}

impl Simulation {
    /// Makes the run to its end, and computes the derivatives of its q and v by parameters: `start.q` and `start.v` (all freedoms, or
    /// `start.q.JOINT`), `effort.JOINT` (a constant effort), and key paths of `Model::params`, masses, lengths, springs, gains and targets, friction,
    /// limits and restitution among them. The derivative is exact for the steps of the run, through its events: an event moves in time.
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
    /// Unknown parameters; events without a derivative; and errors of the run.
    pub fn sensitivity(mut self, keys: &[&str]) -> Result<Sensitivity, Error> {
        let start = self.look(State::clone)?;
        let model = self.model.clone();
        let mechanism = &model.description().mechanism;
        refuse(mechanism)?;
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
        let instants = steps.instants(start.time, end.time);
        let tableau = Tableau::of(stages).map_err(|_| SensitivityError::Step { time: start.time })?;
        let elements = Elements::new(mechanism);
        let subject = Subject {
            mechanism,
            elements: &elements,
            frames: &frames(&model),
            tableau,
            laws: &TimeLaws::new(&elements.motors, &mechanism.forces),
            parameters: &parameters,
        };
        let mut walk = Walk::new(&subject, &start);
        let mut rows = vec![(start.clone(), walk.tangent.clone())];
        let mut run = TracedRun::new(mechanism, stages, 2.0 * (end.time - start.time).max(1.0))
            .map_err(|_| SensitivityError::Step { time: start.time })?;
        let (mut state, mut next) = (start.clone(), 0);
        while state.time < end.time {
            while instants.get(next).is_some_and(|&time| time <= state.time) {
                next += 1;
            }
            let ahead = |index: usize| instants.get(index).map(|time| time - state.time);
            let together = ahead(next).zip(ahead(next + 1)).is_some_and(|(one, other)| one < SHORT * other);
            let until = instants.get(next + usize::from(together)).copied().unwrap_or(end.time);
            let trace = run.step(&mut state, until).map_err(|error| match error {
                TraceError::FirstOrder { time } => SensitivityError::FirstOrder { time },
                TraceError::Step(_) | TraceError::Method(_) => SensitivityError::Step { time: state.time },
            })?;
            walk.along(&trace, &mut |state, tangent| {
                // The end of a step at an instant that moves is no place of its own.
                if tangent.times.iter().all(|by| *by == 0.0) {
                    rows.push((state.clone(), tangent.clone()));
                }
            })?;
        }
        let last = &walk.state;
        let apart = last.position.iter().zip(&end.position).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        let size = end.position.iter().fold(1.0, |size: f64, position| size.max(position.abs()));
        if apart.is_nan() || apart > SAME * size {
            return Err(SensitivityError::Apart { apart }.into());
        }
        let (q, v) = rows.iter().map(|(state, _)| model.flat(state)).unzip();
        let times = rows.iter().map(|(state, _)| state.time).collect();
        let (dq, dv) = rows.into_iter().map(|(_, tangent)| (tangent.positions, tangent.velocities)).unzip();
        let Walk { events, validity, .. } = walk;
        let (valid_within, bounded_by) = (validity.within, validity.causes);
        Ok(Sensitivity { keys: told, freedoms: names, times, q, v, dq, dv, events, valid_within, bounded_by, apart })
    }
}

/// Refuses parts of mechanisms that the equations do not know.
fn refuse(mechanism: &Mechanism) -> Result<(), SensitivityError> {
    let refuse = |part, advice| Err(SensitivityError::Unsupported { part, advice });
    const INSTEAD: &str = "leave them out, or compare runs with other numbers";
    let forces = &mechanism.forces;
    if !(forces.link_loads.is_empty() && forces.drags.is_empty() && forces.joint_courses.is_empty()) {
        return refuse("drag and loads over time", INSTEAD);
    }
    if !forces.gravity_compensations.is_empty() {
        return refuse("motors that hold weights", INSTEAD);
    }
    if mechanism.moves_joints() {
        return refuse("joints that are moved in time", INSTEAD);
    }
    let colliders = &mechanism.nonsmooth.colliders;
    if colliders.iter().any(|collider| collider.surface_velocity != Vector3::zeros()) {
        return refuse("surfaces that move over what carries them", INSTEAD);
    }
    if colliders.iter().any(|collider| matches!(collider.shape, Shape::Ellipsoid { .. } | Shape::Hollow { .. })) {
        return refuse("ellipsoids and ropes", INSTEAD);
    }
    if !mechanism.forces.gravity_compensations.is_empty() {
        return refuse("gravity compensation", "leave it out, or compare runs with other numbers");
    }
    if mechanism.moves_joints() {
        return refuse("joints that are moved in time", "drive these joints with motors");
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
    Ok(())
}

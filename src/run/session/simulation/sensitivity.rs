//! Derivatives of a run by its start, its efforts, and all numbers that have a key path.
//!
//! ```text
//!     run ─ times of its steps ─▶ the same steps with their modes and jumps ─▶ solved to rounding ─▶ ∂q/∂θ, ∂v/∂θ at the ends of steps
//! ```
//!
//! From the derivatives of the start and of constant numbers on ([`parameters`]) everything is exact ([`prepared`]).

use crate::derivatives::events::validity::MetEvent;
use crate::derivatives::events::walk::Walk;
use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::forward::tangent::Tangent;
use crate::mechanism::motion::state::State;
use crate::session::error::Error;
use crate::session::model::Model;
use crate::session::simulation::Simulation;
use crate::session::tangents::Tangents;
use nalgebra::DMatrix;

mod gradient;
mod inertial;
mod parameters;
mod prepared;
mod starts;
mod unknown;

pub use gradient::{Backward, EventLost, Gradient, Lost, SampledEvent, Samples};
use prepared::{Prepared, are_beside};

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
    /// ∂q/∂θ (n × p) at these times, along the entries of v: of ball and floating joints a rotation vector φ in the frame of the joint on the parent,
    /// `R ← exp(φ̂) R`, and of floating joints the displacement of the origin of the child link in that frame. For the quaternion p of q that is
    /// `δp = ½ (0, φ) ∘ p`.
    pub dq: Vec<DMatrix<f64>>,
    /// ∂v/∂θ (n × p).
    pub dv: Vec<DMatrix<f64>>,
    /// The events of the run with the derivatives of their times.
    pub events: Vec<EventSlope>,
    /// How far each parameter may change before an event is missed, added, or comes in another order (p), to first order; infinite without events.
    pub valid_within: Vec<f64>,
    /// The event that bounds it, in words (p).
    pub bounded_by: Vec<String>,
    /// How far the repeated steps end from the run (rad or m).
    pub apart: f64,
    /// Events behind which the derivatives are worse than their order.
    pub warnings: Vec<String>,
}

/// An event of a run with its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct EventSlope {
    /// s.
    pub time: f64,
    /// The element and its event in words, with names in quotation marks.
    pub what: String,
    /// ∂t/∂θ (p).
    pub by: Vec<f64>,
    /// The rate of its function at the event: small for events that graze [unit of the function per s].
    pub rate: f64,
    /// q and v at the event, before they jump.
    pub q: Vec<f64>,
    /// v.
    pub v: Vec<f64>,
    /// ∂q/∂θ (n × p) at the event, which moves in time.
    pub dq: DMatrix<f64>,
    /// ∂v/∂θ (n × p).
    pub dv: DMatrix<f64>,
}

impl EventSlope {
    fn of(model: &Model, event: MetEvent, arms: &DMatrix<f64>) -> Self {
        let MetEvent { time, what, by, rate, state, tangent, .. } = event;
        let (q, v) = model.flat(&state);
        let [dq, dv] = shown(model, &state, tangent, arms);
        EventSlope { time, what, by, rate, q, v, dq, dv }
    }
}

/// The derivatives of q and v from the derivatives of a state; `arms` belong to the origins of links (n × p).
fn shown(model: &Model, state: &State, tangent: Tangent, arms: &DMatrix<f64>) -> [DMatrix<f64>; 2] {
    let Tangent { mut positions, mut velocities, .. } = tangent;
    Tangents::at(model.description(), state).shown(&mut positions, &mut velocities, arms);
    [positions, velocities]
}

/// Puts the instants that were asked for and are beside ends of steps that move among the rows: with the motion from before the end.
fn take_asked(
    rows: &mut Vec<(State, Tangent)>,
    moving: Vec<(State, Tangent)>,
    times: impl Iterator<Item = f64>,
    prepared: &Prepared,
) -> Result<(), SensitivityError> {
    for asked in times {
        let apart = |(state, _): &&(State, Tangent)| (state.time - asked).abs();
        let nearest = moving.iter().min_by(|one, other| apart(one).total_cmp(&apart(other)));
        let Some((state, tangent)) = nearest.filter(|(state, _)| are_beside(state.time, asked)) else {
            if prepared.beside.contains(&asked) {
                return Err(SensitivityError::Beside { time: asked });
            }
            continue;
        };
        let mut tangent = tangent.clone();
        tangent.positions += &tangent.velocities * (asked - state.time);
        let state = prepared.moved_on(state, asked);
        let place = rows.partition_point(|(row, _)| row.time < asked);
        let is_there = rows.get(place).is_some_and(|(row, _)| row.time == asked);
        rows.splice(place..place + usize::from(is_there), [(state, tangent)]);
    }
    Ok(())
}

impl Simulation {
    /// Makes the run to its end, and computes the derivatives of its q and v by parameters: `start.q` and `start.v` (all freedoms, or
    /// `start.q.JOINT`), `effort.JOINT` (a constant effort), and key paths of `Model::params`, masses, lengths, springs, gains and targets, friction,
    /// limits and restitution among them. The derivative is exact for the steps of the run, through its events: an event moves in time.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
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
    pub fn sensitivity(self, keys: &[&str]) -> Result<Sensitivity, Error> {
        self.sensitivity_at(keys, &[])
    }

    /// The same at some times as well (s), each of which is among [`Sensitivity::times`]. Steps end there, but for times within 1e-6 s of an event:
    /// these have its state with the velocities before it.
    ///
    /// # Errors
    /// As [`Simulation::sensitivity`]; times that are not in the run.
    pub fn sensitivity_at(self, keys: &[&str], times: &[f64]) -> Result<Sensitivity, Error> {
        let prepared = Prepared::new(self, keys, times)?;
        let (start, model) = (&prepared.start, &prepared.model);
        let subject = prepared.subject(&prepared.parameters);
        let mut walk = Walk::new(&subject, start);
        let mut rows = vec![(start.clone(), walk.tangent.clone())];
        // Ends of steps that move, at events and ticks, with the derivatives at their times.
        let mut moving: Vec<(State, Tangent)> = Vec::new();
        let (mut run, mut state) = (prepared.traced()?, start.clone());
        while let Some(until) = prepared.until(state.time) {
            let trace = prepared.step(&mut run, &mut state, until)?;
            walk.along(&trace, &mut |state, tangent, moves| {
                // The end of a step at an instant that moves is no place of its own.
                let of = if moves { &mut moving } else { &mut rows };
                of.push((state.clone(), tangent.clone()));
            })?;
        }
        take_asked(&mut rows, moving, times.iter().copied().filter(|time| *time > start.time), &prepared)?;
        let apart = prepared.check(&walk.state)?;
        let (q, v) = rows.iter().map(|(state, _)| model.flat(state)).unzip();
        let times = rows.iter().map(|(state, _)| state.time).collect();
        let arms = prepared.arms();
        let told = rows.into_iter().map(|(state, tangent)| shown(model, &state, tangent, &arms));
        let (dq, dv) = told.map(|[dq, dv]| (dq, dv)).unzip();
        let Walk { events, validity, warnings, .. } = walk;
        let events = events.into_iter().map(|event| EventSlope::of(model, event, &arms)).collect();
        let (valid_within, bounded_by) = (validity.within, validity.causes);
        let Prepared { told, names, .. } = prepared;
        Ok(Sensitivity {
            keys: told,
            freedoms: names,
            times,
            q,
            v,
            dq,
            dv,
            events,
            valid_within,
            bounded_by,
            apart,
            warnings,
        })
    }
}

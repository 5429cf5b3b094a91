//! The gradient of a loss of samples of a run by any number of parameters, against time.
//!
//! ```text
//!     run ─▶ tape ─▶ q, v at the given times ─▶ the loss: its value, ∂/∂q, ∂/∂v ─▶ back to the start: ∂/∂θ
//! ```
//!
//! The steps of the run also end at the samples, so that no interpolation has a part in it. Samples within 1e-6 s of an event have its state.

use crate::derivatives::events::reverse::{Adjoint, Tape};
use crate::derivatives::events::validity::{MetEvent, Validity};
use crate::derivatives::forward::failure::SensitivityError;
use crate::mechanism::motion::state::State;
use crate::session::error::Error;
use crate::session::model::Model;
use crate::session::simulation::Simulation;
use crate::session::simulation::sensitivity::prepared::{Prepared, are_beside};
use crate::session::tangents::Tangents;
use nalgebra::{DMatrix, DVector};

/// The parameters and the samples of a gradient.
#[derive(Clone, Copy, Debug)]
pub struct Backward<'b> {
    /// Parameters, as [`Simulation::sensitivity`] takes them.
    pub keys: &'b [&'b str],
    /// The times of the samples from the start on, in their order (s).
    pub times: &'b [f64],
    /// One of so many states of the tape is kept, and those between are computed again: 1 keeps all. The gradient is the same.
    pub every: usize,
}

/// The samples of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// s.
    pub times: Vec<f64>,
    /// q and v at these times.
    pub q: Vec<Vec<f64>>,
    /// v.
    pub v: Vec<Vec<f64>>,
    /// All events, in their order.
    pub events: Vec<SampledEvent>,
}

/// An event of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampledEvent {
    /// s.
    pub time: f64,
    /// The element and its event in words, with names in quotation marks.
    pub what: String,
    /// q at the event.
    pub q: Vec<f64>,
    /// v at the event, before it jumps.
    pub v: Vec<f64>,
}

/// A loss of samples with its derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lost {
    /// Its value.
    pub value: f64,
    /// Its derivatives by displacements along the entries of v at each sample (n each), as in
    /// [`Sensitivity::dq`](crate::session::Sensitivity::dq).
    pub by_q: Vec<Vec<f64>>,
    /// By the velocities (n each).
    pub by_v: Vec<Vec<f64>>,
    /// By events, if it depends on any.
    pub by_events: Vec<EventLost>,
}

/// The derivatives of a loss by an event.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EventLost {
    /// The number of the event, from 0 on.
    pub event: usize,
    /// By its time.
    pub time: f64,
    /// Derivatives by displacements along the entries of v at the event (n), or empty.
    pub by_q: Vec<f64>,
    /// By the velocities before the event (n), or empty.
    pub by_v: Vec<f64>,
}

/// A loss and its gradient.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gradient {
    /// The parameters θ (p).
    pub keys: Vec<String>,
    /// The loss.
    pub value: f64,
    /// ∂/∂θ (p).
    pub by: Vec<f64>,
    /// Events behind which the derivatives are worse than their order, and starts at which they hold on one side alone.
    pub warnings: Vec<String>,
}

/// Where a sample is: at the start, at the end of a piece of the tape, or beside an event.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Start,
    End(usize),
    Event(usize),
}

impl Prepared {
    /// The event beside an instant, and the state there, of the motion before it.
    fn sample_beside(&self, time: f64, events: &[MetEvent]) -> Result<(Place, State), SensitivityError> {
        let apart = |event: &MetEvent| (event.time - time).abs();
        let nearest = events.iter().enumerate().min_by(|(_, one), (_, other)| apart(one).total_cmp(&apart(other)));
        let (number, event) =
            nearest.filter(|(_, event)| are_beside(event.time, time)).ok_or(SensitivityError::Beside { time })?;
        Ok((Place::Event(number), self.moved_on(&event.state, time)))
    }
}

impl Adjoint {
    /// The derivatives of a loss by a state at a time beside an event, as derivatives by the state at the event and by its time.
    fn at_fixed_time(&self, event: &MetEvent, time: f64) -> Self {
        let velocities = &self.velocities + &self.positions * (time - event.time);
        let along = |rates: &DMatrix<f64>, by: &DVector<f64>| rates.column(0).dot(by);
        let by_time = along(&event.along.positions, &self.positions) + along(&event.along.velocities, &velocities);
        Adjoint { positions: self.positions.clone(), velocities, time: -by_time }
    }
}

impl SampledEvent {
    fn of(model: &Model, event: &MetEvent) -> Self {
        let (q, v) = model.flat(&event.state);
        SampledEvent { time: event.time, what: event.what.clone(), q, v }
    }
}

impl EventLost {
    /// The number of the event with its derivatives, for n degrees of freedom.
    fn checked(&self, n: usize, events: usize) -> Result<(usize, Adjoint), Error> {
        if self.event >= events {
            return Err(Error::Count {
                what: "events up to the one of the loss",
                given: events,
                wanted: self.event + 1,
            });
        }
        let part = |what, of: &[f64]| match of.len() {
            0 => Ok(DVector::zeros(n)),
            given if given != n => Err(Error::Count { what, given, wanted: n }),
            _ => Ok(DVector::from_column_slice(of)),
        };
        let positions = part("derivatives of the loss by q at an event", &self.by_q)?;
        let velocities = part("derivatives of the loss by v at an event", &self.by_v)?;
        Ok((self.event, Adjoint { positions, velocities, time: self.time }))
    }
}

impl Simulation {
    /// Makes the run to its end, and computes the gradient of a loss of its samples by parameters, at a cost that hardly depends on their number.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use catena::prelude::*;
    /// use catena::session::{Backward, Lost, Samples};
    ///
    /// let model = Model::load("robots/double_pendulum.urdf")?;
    /// // The square of the first angle at the end.
    /// let loss = |samples: &Samples| {
    ///     let angle = samples.q[0][0];
    ///     Lost { value: angle * angle, by_q: vec![vec![2.0 * angle, 0.0]], by_v: vec![vec![0.0; 2]], by_events: vec![] }
    /// };
    /// let asked = Backward { keys: &["start.q.shoulder", "lower_arm.mass"], times: &[0.5], every: 1 };
    /// let found = Simulation::new(&model).duration(0.5).start([("shoulder", 1.0)])?.gradient(&asked, loss)?;
    /// assert_eq!(found.by.len(), 2);
    /// # Ok::<(), catena::session::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Simulation::sensitivity`]; motors with ticks and corners that stick have no derivatives against time; a loss with other numbers of samples
    /// or degrees of freedom.
    pub fn gradient(self, asked: &Backward, loss: impl FnOnce(&Samples) -> Lost) -> Result<Gradient, Error> {
        let prepared = Prepared::new(self, asked.keys, asked.times)?;
        let (subject, mut run) = (prepared.subject(&[]), prepared.traced()?);
        let mut tape = Tape::new(&subject, &prepared.start, asked.every);
        let mut samples = Samples::default();
        let mut places: Vec<(Place, State)> = Vec::new();
        let (mut state, mut count) = (prepared.start.clone(), 0);
        let is_sample = |time: &f64| asked.times.contains(time) && !prepared.beside.contains(time);
        if is_sample(&state.time) {
            places.push((Place::Start, state.clone()));
        }
        while let Some(until) = prepared.until(state.time) {
            tape.add(prepared.step(&mut run, &mut state, until)?)?;
            if is_sample(&state.time) {
                places.push((Place::End(count), tape.state().clone()));
            }
            count += 1;
        }
        for &time in &prepared.beside {
            let place = places.partition_point(|(_, state)| state.time < time);
            places.insert(place, prepared.sample_beside(time, tape.events())?);
        }
        for (_, state) in &places {
            let (q, v) = prepared.model.flat(state);
            samples.times.push(state.time);
            samples.q.push(q);
            samples.v.push(v);
        }
        prepared.check(tape.state())?;
        let mut warnings = tape.warnings().to_vec();
        let Validity { within, causes } = tape.start_validity(&prepared.parameters);
        let kinks = within.iter().zip(causes).zip(&prepared.told).filter(|((within, _), _)| **within == 0.0);
        warnings.extend(kinks.map(|((_, cause), key)| format!("{key}: {cause}")));
        samples.events = tape.events().iter().map(|event| SampledEvent::of(&prepared.model, event)).collect();
        let lost = loss(&samples);
        let n = prepared.start.velocity.len();
        for (what, rows) in [("derivatives of the loss by q", &lost.by_q), ("derivatives of the loss by v", &lost.by_v)]
        {
            let given = rows.iter().find(|row| row.len() != n).map(Vec::len);
            if let Some((given, wanted)) =
                given.map(|given| (given, n)).or((rows.len() != places.len()).then_some((rows.len(), places.len())))
            {
                return Err(Error::Count { what, given, wanted });
            }
        }
        // Losses are of q and v: back to the states, and to the links in their bodies.
        let mut by_arms = DVector::zeros(n);
        let mut of_state = |by: Adjoint, state: &State| {
            let Adjoint { mut positions, mut velocities, time } = by;
            let tangents = Tangents::at(prepared.model.description(), state);
            by_arms += tangents.pulled_back(&mut positions, &mut velocities);
            Adjoint { positions, velocities, time }
        };
        let by_sample: Vec<Adjoint> = (places.iter().zip(lost.by_q.iter().zip(&lost.by_v)))
            .map(|((_, state), (by_q, by_v))| {
                let [positions, velocities] = [by_q, by_v].map(|of| DVector::from_column_slice(of));
                of_state(Adjoint { positions, velocities, time: 0.0 }, state)
            })
            .collect();
        let of_sample = |place: Place| {
            let sample = places.iter().position(|(known, _)| *known == place)?;
            Some(by_sample[sample].clone())
        };
        let of_events = places.iter().zip(&by_sample).filter_map(|((place, state), by)| match place {
            Place::Event(event) => Some((*event, by.at_fixed_time(&tape.events()[*event], state.time))),
            _ => None,
        });
        let mut by_event: Vec<(usize, Adjoint)> = of_events.collect();
        for by in &lost.by_events {
            let (event, by) = by.checked(n, samples.events.len())?;
            by_event.push((event, of_state(by, &tape.events()[event].state)));
        }
        let of_event = |event: usize| {
            let own = by_event.iter().filter(|(own, _)| *own == event).map(|(_, by)| by.clone());
            own.reduce(|sum, by| sum.plus(&by))
        };
        let mut by = tape.gradient(&prepared.parameters, &|piece| of_sample(Place::End(piece)), &of_event)?;
        if let Some(start) = of_sample(Place::Start) {
            for (own, parameter) in by.iter_mut().zip(&prepared.parameters) {
                *own += start.positions.dot(&parameter.position) + start.velocities.dot(&parameter.velocity);
            }
        }
        for (own, parameter) in by.iter_mut().zip(&prepared.parameters) {
            *own += by_arms.dot(&parameter.arms);
        }
        Ok(Gradient { keys: prepared.told, value: lost.value, by, warnings })
    }
}

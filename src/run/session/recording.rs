//! An observer that keeps a run in memory and can replay it to another observer, such as a log.

use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::simulation::{AccuracySoFar, Observer, ObserverError, Sample, StepEnd};
use std::sync::{Arc, Mutex, PoisonError};

/// The samples, events and contacts of a run.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// Times of the samples (s).
    pub times: Vec<f64>,
    /// Joint positions of the state, sample after sample.
    pub positions: Vec<f64>,
    /// Joint velocities of the state, sample after sample.
    pub velocities: Vec<f64>,
    /// The ends of those steps that contain samples.
    pub steps: Vec<StepEnd>,
    /// The index of the step of each sample.
    step_of: Vec<usize>,
    /// Events, each with the index of the next sample.
    events: Vec<(usize, Event)>,
    /// The ends of steps with events, each with the number of events up to it.
    eventful: Vec<(usize, StepEnd)>,
    /// Accuracies that the run told, each with the index of the next sample.
    accuracies: Vec<(usize, AccuracySoFar)>,
    /// Contacts, each with the index of its sample.
    contacts: Vec<(usize, Vec<ContactPoint>)>,
    /// The efforts that sampled motors hold at samples, an entry a motor, sample after sample; empty without such motors.
    pub held: Vec<Option<f64>>,
}

impl Recording {
    /// Positions and velocities of a sample.
    pub fn sample(&self, number: usize) -> (&[f64], &[f64]) {
        let part = |all: &'_ [f64]| {
            let width = all.len() / self.times.len();
            number * width..(number + 1) * width
        };
        (&self.positions[part(&self.positions)], &self.velocities[part(&self.velocities)])
    }

    /// The efforts that sampled motors hold at a sample: an entry a motor, or empty.
    pub fn held_at(&self, number: usize) -> &[Option<f64>] {
        let motors = self.held.len() / self.times.len();
        &self.held[number * motors..(number + 1) * motors]
    }

    /// The end of the step that contains a sample.
    pub fn step_of(&self, number: usize) -> &StepEnd {
        &self.steps[self.step_of[number]]
    }

    /// All events.
    pub fn events(&self) -> impl Iterator<Item = &Event> {
        self.events.iter().map(|(_, event)| event)
    }

    /// The closed contacts at samples: the index of a sample, and its contacts. Samples without any may be left out.
    pub fn contacts(&self) -> impl Iterator<Item = (usize, &[ContactPoint])> {
        self.contacts.iter().map(|(sample, points)| (*sample, points.as_slice()))
    }

    /// Adds a contact at a sample, after all of earlier samples.
    pub fn add_contact(&mut self, sample: usize, point: ContactPoint) {
        match self.contacts.last_mut() {
            Some((last, points)) if *last == sample => points.push(point),
            _ => self.contacts.push((sample, vec![point])),
        }
    }

    /// Replays the run to another observer.
    ///
    /// # Errors
    /// Any error of the observer.
    pub fn show_to(&self, observer: &mut dyn Observer) -> Result<(), ObserverError> {
        let (mut events, mut contacts) = (self.events.iter().peekable(), self.contacts.iter().peekable());
        let (mut accuracies, mut eventful) = (self.accuracies.iter().peekable(), self.eventful.iter().peekable());
        let mut shown = 0;
        for number in 0..=self.times.len() {
            while let Some((_, event)) = events.next_if(|(before, _)| *before <= number) {
                observer.event(event);
                shown += 1;
                while let Some((_, end)) = eventful.next_if(|(events, _)| *events <= shown) {
                    observer.step(end);
                }
            }
            while let Some((_, so_far)) = accuracies.next_if(|(before, _)| *before <= number) {
                observer.accuracy(so_far);
            }
            while let Some((_, points)) = contacts.next_if(|(of, _)| *of <= number) {
                observer.contacts(points);
            }
            if number < self.times.len() {
                let held = self.held_at(number);
                if !held.is_empty() {
                    observer.held_efforts(held);
                }
                let (position, velocity) = self.sample(number);
                observer.sample(&Sample {
                    time: self.times[number],
                    position,
                    velocity,
                    step: self.step_of(number),
                })?;
            }
        }
        Ok(())
    }
}

impl Observer for Recording {
    fn begin_again(&mut self, _: &MethodDescription) -> Result<(), ObserverError> {
        *self = Recording::default();
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.times.push(sample.time);
        self.positions.extend_from_slice(sample.position);
        self.velocities.extend_from_slice(sample.velocity);
        if self.steps.last() != Some(sample.step) {
            self.steps.push(*sample.step);
        }
        self.step_of.push(self.steps.len() - 1);
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        let events = self.events.len();
        if self.eventful.last().map_or(0, |(known, _)| *known) < events {
            self.eventful.push((events, *end));
        }
    }

    fn event(&mut self, event: &Event) {
        self.events.push((self.times.len(), *event));
    }

    fn accuracy(&mut self, so_far: &AccuracySoFar) {
        self.accuracies.push((self.times.len(), *so_far));
    }

    fn contacts(&mut self, points: &[ContactPoint]) {
        self.contacts.push((self.times.len(), points.to_vec()));
    }

    fn held_efforts(&mut self, efforts: &[Option<f64>]) {
        self.held.extend_from_slice(efforts);
    }
}

/// A recording that other code can read during the run.
#[derive(Clone, Debug, Default)]
pub struct SharedRecording(Arc<Mutex<Recording>>);

impl SharedRecording {
    /// Moves the recording out.
    pub fn take(&self) -> Recording {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn with<R>(&self, use_it: impl FnOnce(&mut Recording) -> R) -> R {
        use_it(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Observer for SharedRecording {
    fn begin_again(&mut self, method: &MethodDescription) -> Result<(), ObserverError> {
        self.with(|recording| recording.begin_again(method))
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.with(|recording| recording.sample_seen(sample))
    }

    fn step(&mut self, end: &StepEnd) {
        self.with(|recording| recording.step(end));
    }

    fn event(&mut self, event: &Event) {
        self.with(|recording| recording.event(event));
    }

    fn accuracy(&mut self, so_far: &AccuracySoFar) {
        self.with(|recording| recording.accuracy(so_far));
    }

    fn contacts(&mut self, points: &[ContactPoint]) {
        self.with(|recording| recording.contacts(points));
    }

    fn held_efforts(&mut self, efforts: &[Option<f64>]) {
        self.with(|recording| recording.held_efforts(efforts));
    }
}

impl Recording {
    fn sample_seen(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        Observer::sample(self, sample)
    }
}

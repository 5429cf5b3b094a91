//! A run that owns its model and its observers.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::output::log::Recorder;
use crate::output::report::SpeedWatch;
use crate::session::model::Model;
use crate::simulation::{AccuracySoFar, Finished, Observer, ObserverError, Sample, Simulation, StepEnd};
use self_cell::{MutBorrow, self_cell};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The data that a run borrows while it lasts.
pub(crate) struct Held {
    pub model: Model,
    pub kept: Vec<Rule>,
    pub interrupt: Arc<AtomicBool>,
    /// The ranks of the closures at the start.
    pub counted: Option<Arc<Counted>>,
    pub watch: MutBorrow<Watch>,
}

type Driven<'h> = Option<Simulation<'h>>;

self_cell!(
    /// A simulation and what it borrows.
    pub(crate) struct Engine {
        owner: Held,

        #[not_covariant]
        dependent: Driven,
    }
);

impl Engine {
    /// Calls a function with the simulation.
    pub fn with<R>(&self, look: impl FnOnce(&Simulation) -> R) -> Option<R> {
        self.with_dependent(|_, driven| driven.as_ref().map(look))
    }

    /// Calls a function that may change the simulation.
    pub fn with_mut<R>(&mut self, change: impl FnOnce(&mut Simulation<'_>) -> R) -> Option<R> {
        self.with_dependent_mut(|_, driven| driven.as_mut().map(change))
    }

    /// Ends the simulation and returns its results and observers.
    pub fn finish(mut self) -> Option<(Finished, Held)> {
        let finished = self.with_dependent_mut(|_, driven| driven.take().map(Simulation::finish))?;
        Some((finished, self.into_owner()))
    }
}

/// The observers of a run.
#[derive(Default)]
pub(crate) struct Watch {
    pub recorder: Option<Recorder>,
    pub speeds: Option<SpeedWatch>,
    pub others: Vec<Box<dyn Observer>>,
}

impl Watch {
    /// Whether there are no observers.
    pub fn is_empty(&self) -> bool {
        self.recorder.is_none() && self.speeds.is_none() && self.others.is_empty()
    }

    /// Whether an observer looks at samples.
    pub fn looks(&self) -> bool {
        self.recorder.is_some() || self.others.iter().any(|observer| !observer.skips_samples())
    }

    fn all(&mut self) -> impl Iterator<Item = &mut dyn Observer> {
        let recorder = self.recorder.iter_mut().map(|one| one as &mut dyn Observer);
        let speeds = self.speeds.iter_mut().map(|one| one as &mut dyn Observer);
        recorder.chain(self.others.iter_mut().map(|one| &mut **one as &mut dyn Observer)).chain(speeds)
    }
}

impl Observer for Watch {
    fn begin_again(&mut self, method: &MethodDescription) -> Result<(), ObserverError> {
        self.all().try_for_each(|observer| observer.begin_again(method))
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.all().try_for_each(|observer| observer.sample(sample))
    }

    fn step(&mut self, end: &StepEnd) {
        self.all().for_each(|observer| observer.step(end));
    }

    fn event(&mut self, event: &Event) {
        self.all().for_each(|observer| observer.event(event));
    }

    fn accuracy(&mut self, so_far: &AccuracySoFar) {
        self.all().for_each(|observer| observer.accuracy(so_far));
    }

    fn contacts(&mut self, points: &[ContactPoint]) {
        self.all().for_each(|observer| observer.contacts(points));
    }

    fn skips_samples(&self) -> bool {
        !self.looks()
    }
}

//! The observers of a run: its log, the observers of its user, and the speeds of joints for its report.

use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::output::log::Recorder;
use crate::output::report::SpeedWatch;
use crate::simulation::{AccuracySoFar, Observer, ObserverError, Sample, StepEnd};

/// The observers of a run.
#[derive(Default)]
pub(crate) struct Watch {
    pub recorder: Option<Recorder>,
    pub speeds: Option<SpeedWatch>,
    pub others: Vec<Box<dyn Observer>>,
    /// Whether samples are taken for the speeds alone.
    pub samples_speeds: bool,
}

impl Watch {
    /// The observers as a run takes them, and none if there is none.
    pub fn as_list<R>(&mut self, work: impl FnOnce(&mut [&mut dyn Observer]) -> R) -> R {
        if self.recorder.is_none() && self.speeds.is_none() && self.others.is_empty() {
            return work(&mut []);
        }
        work(&mut [self as &mut dyn Observer])
    }

    /// Whether an observer looks at samples.
    pub fn looks(&self) -> bool {
        self.recorder.is_some()
            || self.others.iter().any(|observer| !observer.skips_samples())
            || (self.samples_speeds && self.speeds.is_some())
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

    fn held_efforts(&mut self, efforts: &[Option<f64>]) {
        self.all().for_each(|observer| observer.held_efforts(efforts));
    }

    fn skips_samples(&self) -> bool {
        !self.looks()
    }

    fn skips_contacts(&self) -> bool {
        self.recorder.is_none() && self.others.iter().all(|observer| observer.skips_contacts())
    }
}

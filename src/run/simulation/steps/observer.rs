//! The interface of observers: samples at a fixed rate, and the figures at the end of every step.

use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::energy::{Energy, Violation};
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::{MethodDescription, StepOutcome};
use crate::simulation::tolerance::accuracy_so_far::AccuracySoFar;

/// The mechanism at one sampled instant.
pub struct Sample<'s> {
    /// The sampled time (s).
    pub time: f64,
    /// Joint positions and velocities from dense output.
    pub position: &'s [f64],
    /// Joint velocities from dense output.
    pub velocity: &'s [f64],
    /// The end of the step in which the sample lies (or the start of the run).
    pub step: &'s StepEnd,
}

/// The figures at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepEnd {
    /// Time at the end of the step (s).
    pub time: f64,
    /// Energy there.
    pub energy: Energy,
    /// Energy dissipated since the start of the run, and work of external efforts (J).
    pub exchange: Exchange,
    /// The error of the energy balance from the start of the run to here (J).
    pub deviation: f64,
    /// Constraint violation there.
    pub violation: Violation,
    /// The cost of the step.
    pub outcome: StepOutcome,
    /// Accepted steps, their iterations and rejected attempts, from the start of the run to here.
    pub so_far: Counts,
}

/// The cost of a run or of a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Accepted steps.
    pub steps: usize,
    /// Iterations of all steps.
    pub iterations: usize,
    /// Rejected attempts.
    pub rejected: usize,
}

/// Any error of an observer (a full disk, a closed pipe).
pub type ObserverError = Box<dyn std::error::Error + Send + Sync>;

/// Receives the samples, steps and events of a run.
pub trait Observer: Send {
    /// A sample of the motion, in order of time, the first at the start and the last at the end of the run.
    ///
    /// # Errors
    /// Any error that stops the run, such as a full disk.
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError>;

    /// The run restarts from its start, because its steps were too coarse: everything received so far is void. The samples come again from the
    /// first one, from steps made by this method.
    ///
    /// # Errors
    /// Any error that stops the run.
    fn begin_again(&mut self, _method: &MethodDescription) -> Result<(), ObserverError> {
        Ok(())
    }

    /// The end of a step, before the samples inside it. Independent islands pass on the ends of steps with events alone; the energies are those of the
    /// whole, of islands inside their steps between those at the nearest samples and ends of steps.
    fn step(&mut self, _end: &StepEnd) {}

    /// An event, before the end of the step at whose end it happened. Independent islands pass on their events between two samples of the whole;
    /// events of one instant come in the order of the islands.
    fn event(&mut self, _event: &Event) {}

    /// The accuracy up to the end of the last step. It is called from time to time, and only in runs with a tolerance that estimate their own error
    /// ([`Simulation::run`](crate::simulation::Simulation::run)).
    fn accuracy(&mut self, _so_far: &AccuracySoFar) {}

    /// The closed contacts at the instant of the next sample, in the order of their pairs; only where a mechanism has pairs of shapes that may touch.
    fn contacts(&mut self, _points: &[ContactPoint]) {}

    /// The efforts that sampled motors hold at the instant of the next sample [N m or N]: an entry a motor of the mechanism, `None` for
    /// continuous ones and where they are not known; only where a mechanism has sampled motors. At a tick it is the effort that begins there.
    fn held_efforts(&mut self, _efforts: &[Option<f64>]) {}

    /// Whether it looks at steps and events alone. Samples and contacts are worked out only if an observer looks at them; those of the start and the
    /// end may come all the same.
    fn skips_samples(&self) -> bool {
        false
    }

    /// Whether it does not look at contacts. They are worked out at samples only if an observer looks at them.
    fn skips_contacts(&self) -> bool {
        self.skips_samples()
    }
}

/// Whether an observer looks at contacts.
pub(crate) fn any_looks_at_contacts(observers: &[&mut dyn Observer]) -> bool {
    observers.iter().any(|observer| !observer.skips_contacts())
}

/// Passes a sample to every observer.
pub(crate) fn show(observers: &mut [&mut dyn Observer], sample: &Sample) -> Result<(), ObserverError> {
    observers.iter_mut().try_for_each(|observer| observer.sample(sample))
}

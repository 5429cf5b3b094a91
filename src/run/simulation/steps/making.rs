//! The integrator of a run or of an island: with an estimate of its error, or without.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::{Event, JointStatus};
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Cost, Integrator, MethodDescription, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::accuracy_so_far::AccuracySoFar;
use crate::simulation::tolerance::assessed::Assessed;
use crate::stepping::integrator::Lobatto;

/// The integrator.
pub enum Making<'a> {
    /// An integrator alone.
    Alone(RunIntegrator),
    /// An integrator with an estimate of its error; it may restart.
    Telling(Box<Assessed<'a>>),
}

impl From<RunIntegrator> for Making<'_> {
    fn from(alone: RunIntegrator) -> Self {
        Making::Alone(alone)
    }
}

impl From<Lobatto> for Making<'_> {
    fn from(lobatto: Lobatto) -> Self {
        Making::Alone(lobatto.into())
    }
}

/// An integrator that may tell its accuracy during a run.
pub(crate) trait Tells {
    /// The accuracy so far, if it is known.
    fn so_far(&self) -> Option<AccuracySoFar> {
        None
    }

    /// A bound of the overlap of shapes in the steps so far (m), where it is known.
    fn overlap(&self) -> f64 {
        0.0
    }

    /// Whether forces inside their cones are known to hold all closed contacts in the state at the end of the last step.
    fn holds_all(&self, _state: &State) -> bool {
        false
    }
}

impl Tells for dyn Integrator + '_ {}

impl Tells for Making<'_> {
    fn so_far(&self) -> Option<AccuracySoFar> {
        match self {
            Making::Telling(assessed) => assessed.so_far(),
            Making::Alone(_) => None,
        }
    }

    fn overlap(&self) -> f64 {
        match self {
            Making::Alone(alone) => alone.overlap(),
            Making::Telling(assessed) => assessed.overlap(),
        }
    }

    fn holds_all(&self, state: &State) -> bool {
        match self {
            Making::Alone(alone) => alone.holds_all(state),
            Making::Telling(assessed) => assessed.holds_all(state),
        }
    }
}

impl<'a> Making<'a> {
    /// The integrator with an estimate of its error, if it is one.
    pub(crate) fn telling(&mut self) -> Option<&mut Assessed<'a>> {
        match self {
            Making::Telling(assessed) => Some(assessed),
            Making::Alone(_) => None,
        }
    }

    /// Gives a motor a target from now on.
    pub(crate) fn aim(&mut self, motor: usize, value: f64) {
        match self {
            Making::Alone(alone) => alone.aim(motor, value),
            Making::Telling(assessed) => assessed.aim(motor, value),
        }
    }

    fn inner(&self) -> &dyn Integrator {
        match self {
            Making::Alone(alone) => alone,
            Making::Telling(assessed) => assessed.as_ref(),
        }
    }

    fn inner_mut(&mut self) -> &mut dyn Integrator {
        match self {
            Making::Alone(alone) => alone,
            Making::Telling(assessed) => assessed.as_mut(),
        }
    }
}

impl Integrator for Making<'_> {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        self.inner_mut().step(mechanism, inputs, state, until)
    }

    fn begins_again(&self) -> bool {
        self.inner().begins_again()
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.inner_mut().dense(mechanism, time, position, velocity);
    }

    fn bodies(&self) -> Option<&[BodyState]> {
        self.inner().bodies()
    }

    fn take_abandoned(&mut self) -> Cost {
        self.inner_mut().take_abandoned()
    }

    fn description(&self) -> MethodDescription {
        self.inner().description()
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        self.inner_mut().take_events(events);
    }

    fn joint_status(&self, mechanism: &Mechanism, state: &State, body: usize) -> JointStatus {
        self.inner().joint_status(mechanism, state, body)
    }

    fn contacts(&self, mechanism: &Mechanism, state: &State, out: &mut Vec<ContactPoint>) {
        self.inner().contacts(mechanism, state, out);
    }
}

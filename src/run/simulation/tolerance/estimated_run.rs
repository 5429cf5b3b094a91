//! The steps of a run or island, with an estimate of their error if one is wanted.
//!
//! ```text
//!     EstimatedRun = RunIntegrator (the steps) + ErrorEstimate (a motion beside them, restarts)
//! ```

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::{Event, JointStatus};
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Cost, Integrator, MethodDescription, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::accuracy::{Accuracy, UnknownAccuracy};
use crate::simulation::tolerance::accuracy_so_far::{AccuracySoFar, Tells};
use crate::simulation::tolerance::error_estimate::ErrorEstimate;
use crate::simulation::tolerance::handed::{Fineness, Handed};
use crate::simulation::tolerance::terms::Terms;
use crate::stepping::integrator::{Lobatto, MethodError};

/// The steps, and the estimate of their error.
pub struct EstimatedRun<'a> {
    run: RunIntegrator,
    estimate: Option<Box<ErrorEstimate<'a>>>,
}

impl From<RunIntegrator> for EstimatedRun<'_> {
    fn from(run: RunIntegrator) -> Self {
        EstimatedRun { run, estimate: None }
    }
}

impl From<Lobatto> for EstimatedRun<'_> {
    fn from(lobatto: Lobatto) -> Self {
        RunIntegrator::from(lobatto).into()
    }
}

impl<'a> EstimatedRun<'a> {
    /// With an estimate of the error; it may restart.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub fn new(mechanism: &Mechanism, terms: Terms<'a>) -> Result<Self, MethodError> {
        let (estimate, run) = ErrorEstimate::new(mechanism, terms)?;
        Ok(EstimatedRun { run, estimate: Some(Box::new(estimate)) })
    }

    /// The same, going on from what the runs of other groups have handed on.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub(crate) fn going_on(mechanism: &Mechanism, terms: Terms<'a>, handed: Handed) -> Result<Self, MethodError> {
        let (estimate, run) = ErrorEstimate::going_on(mechanism, terms, handed)?;
        Ok(EstimatedRun { run, estimate: Some(Box::new(estimate)) })
    }

    /// The same from the beginning, as fine as that.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub(crate) fn as_fine_as(mechanism: &Mechanism, terms: Terms<'a>, fineness: Fineness) -> Result<Self, MethodError> {
        let (estimate, run) = ErrorEstimate::as_fine_as(mechanism, terms, fineness)?;
        Ok(EstimatedRun { run, estimate: Some(Box::new(estimate)) })
    }

    /// Hands on the run where it is; `None` if it begins again, or has no estimate.
    pub(crate) fn hand_on(&mut self, mechanism: &Mechanism, state: &State) -> Option<Handed> {
        let EstimatedRun { run, estimate } = self;
        estimate.as_mut()?.hand_on(mechanism, state, run)
    }

    /// The same for a run that goes back to an instant (s).
    pub(crate) fn hand_back(&mut self, mechanism: &Mechanism, time: f64) -> Option<Handed> {
        let EstimatedRun { run, estimate } = self;
        estimate.as_mut()?.hand_back(mechanism, time, run)
    }

    /// How fine its next beginning is; `None` without an estimate.
    pub(crate) fn next_fineness(&mut self) -> Option<Fineness> {
        let EstimatedRun { run, estimate } = self;
        Some(estimate.as_mut()?.next_fineness(run))
    }

    /// The steps alone; `None` where their error is estimated by a second motion.
    pub(crate) fn alone(&self) -> Option<&RunIntegrator> {
        if self.estimate.is_none() { Some(&self.run) } else { None }
    }

    /// The same, to be changed.
    pub(crate) fn alone_mut(&mut self) -> Option<&mut RunIntegrator> {
        if self.estimate.is_none() { Some(&mut self.run) } else { None }
    }

    /// Prepares a restart with finer steps where these were too coarse, and with the same otherwise; nothing without an estimate.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub fn begin_again(&mut self, mechanism: &Mechanism) -> Result<(), MethodError> {
        if let Some(estimate) = &mut self.estimate {
            self.run = estimate.begin_again(mechanism, &self.run)?;
        }
        Ok(())
    }

    /// Forbids restarts, whatever the error.
    pub(crate) fn settle(&mut self) {
        self.estimate.iter_mut().for_each(|estimate| estimate.settle());
    }

    /// The accuracy up to this state, the end of the last step, or the reason why it is not known; `None` without an estimate.
    pub(crate) fn accuracy(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
    ) -> Option<Result<Accuracy, UnknownAccuracy>> {
        let EstimatedRun { run, estimate } = self;
        estimate.as_mut().map(|estimate| estimate.accuracy(mechanism, state, run))
    }

    /// Gives a motor a target from now on.
    pub(crate) fn aim(&mut self, motor: usize, value: f64) {
        if let Some(estimate) = &mut self.estimate {
            estimate.drive(&mut self.run);
        }
        self.run.aim(motor, value);
    }
}

impl Tells for EstimatedRun<'_> {
    fn so_far(&self) -> Option<AccuracySoFar> {
        self.estimate.as_ref().and_then(|estimate| estimate.so_far())
    }

    fn overlap(&self) -> f64 {
        self.run.overlap()
    }

    fn holds_all(&self, state: &State) -> bool {
        self.run.holds_all(state)
    }
}

impl Integrator for EstimatedRun<'_> {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        match &mut self.estimate {
            None => self.run.step(mechanism, inputs, state, until),
            Some(estimate) => estimate.step(mechanism, inputs, state, until, &mut self.run),
        }
    }

    fn begins_again(&self) -> bool {
        self.estimate.as_ref().is_some_and(|estimate| estimate.begins_again())
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.run.dense(mechanism, time, position, velocity);
    }

    fn bodies(&self) -> Option<&[BodyState]> {
        self.run.bodies()
    }

    fn take_abandoned(&mut self) -> Cost {
        self.run.take_abandoned()
    }

    fn description(&self) -> MethodDescription {
        self.run.description()
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        let before = events.len();
        self.run.take_events(events);
        if let Some(estimate) = &mut self.estimate {
            estimate.see_events(&events[before..]);
        }
    }

    fn joint_status(&self, mechanism: &Mechanism, state: &State, body: usize) -> JointStatus {
        self.run.joint_status(mechanism, state, body)
    }

    fn contacts(&self, mechanism: &Mechanism, state: &State, out: &mut Vec<ContactPoint>) {
        self.run.contacts(mechanism, state, out);
    }

    fn held_efforts(&self, inside: bool, out: &mut Vec<Option<f64>>) {
        self.run.held_efforts(inside, out);
    }
}

//! The integrator of a run: the scheme alone, or with events if the mechanism has limits, dry friction, motors or contacts.

use crate::events::Eventful;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::distance::{probes, probes_of_bodies};
use crate::mechanism::motion::event::{Event, JointStatus};
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::stepping::integrator::{Lobatto, MethodError};
use crate::stepping::recipe::{Recipe, Steps};
use crate::stepping::trees::other_tree::OnOtherTree;
use nalgebra::Vector3;
use std::sync::Arc;

/// The integrator of a run, or of an island.
#[derive(Clone)]
pub enum RunIntegrator {
    /// Of a smooth motion.
    Smooth(Box<Lobatto>),
    /// Of a smooth motion on another spanning tree than the file's.
    OnOtherTree(Box<OnOtherTree>),
    /// Of one with events.
    Eventful(Box<Eventful>),
}

impl From<Lobatto> for RunIntegrator {
    fn from(lobatto: Lobatto) -> Self {
        RunIntegrator::Smooth(Box::new(lobatto))
    }
}

impl RunIntegrator {
    /// The one for a mechanism, with these steps and rules that leave nothing out.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn new(mechanism: &Mechanism, steps: Steps, kept: &[Rule]) -> Result<Self, MethodError> {
        let recipe = Recipe { steps, kept: kept.to_vec() };
        if !mechanism.nonsmooth.is_empty() {
            return Ok(RunIntegrator::Eventful(Box::new(Eventful::new(mechanism, recipe)?)));
        }
        Ok(match OnOtherTree::new(mechanism, &[], &recipe)? {
            Some(other) => RunIntegrator::OnOtherTree(Box::new(other)),
            None => RunIntegrator::Smooth(Box::new(recipe.lobatto(mechanism)?)),
        })
    }

    /// The same from a state in which the closures were counted already. Events hold joints, which leaves other mechanisms: they count anew,
    /// and so does another spanning tree.
    #[must_use]
    pub fn counted(self, counted: Option<Arc<Counted>>) -> Self {
        match self {
            RunIntegrator::Smooth(lobatto) => RunIntegrator::from(lobatto.counted(counted)),
            RunIntegrator::Eventful(_) | RunIntegrator::OnOtherTree(_) => self,
        }
    }

    /// Whether a step that was to be chosen for its accuracy was shortened for the stability of the scheme.
    pub fn was_held_by_stability(&self) -> bool {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.was_held_by_stability(),
            RunIntegrator::OnOtherTree(other) => other.was_held_by_stability(),
            RunIntegrator::Eventful(eventful) => eventful.was_held_by_stability(),
        }
    }

    /// The error of samples inside the steps so far, beside that of their ends (m); `None` where it is not known.
    pub(crate) fn between(&self) -> Option<f64> {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.between(),
            RunIntegrator::OnOtherTree(other) => other.between(),
            RunIntegrator::Eventful(eventful) => eventful.between(),
        }
    }

    /// The largest error of samples inside steps that were too long for a damper (m), of which those of their ends know nothing.
    pub(crate) fn ringing_inside(&self) -> f64 {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.ringing_inside(),
            RunIntegrator::Eventful(eventful) => eventful.ringing_inside(),
            // With closed loops a run beside this one has steps of its own.
            RunIntegrator::OnOtherTree(_) => 0.0,
        }
    }

    /// Carries a companion from the first step on, where that tells the errors of the steps: until the first event, if there are any; returns whether it
    /// does.
    pub(crate) fn accompany(&mut self, mechanism: &Mechanism) -> bool {
        match self {
            _ if mechanism.has_closures() => return false,
            RunIntegrator::Smooth(lobatto) => lobatto.accompany(mechanism),
            RunIntegrator::Eventful(eventful) => eventful.accompany(),
            // Only loops are made on another tree.
            RunIntegrator::OnOtherTree(_) => return false,
        }
        true
    }

    /// Carries it no more.
    pub(crate) fn leave_companion(&mut self) {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.leave_companion(),
            RunIntegrator::Eventful(eventful) => eventful.leave_companion(),
            RunIntegrator::OnOtherTree(_) => {}
        }
    }

    /// Its probes after the last step, which has left the run in `state`; `None` if there is none, or none any more.
    pub(crate) fn companion_probes(&self, mechanism: &Mechanism, state: &State) -> Option<Vec<Vector3<f64>>> {
        match self {
            RunIntegrator::Smooth(lobatto) => {
                let companion = lobatto.companion()?;
                let placed = lobatto.companion_bodies().map(|bodies| probes_of_bodies(mechanism, bodies));
                Some(placed.unwrap_or_else(|| probes(mechanism, companion.state())))
            }
            RunIntegrator::Eventful(eventful) => {
                let mut there = state.clone();
                eventful.place_companion(&mut there).then(|| probes(mechanism, &there))
            }
            RunIntegrator::OnOtherTree(_) => None,
        }
    }

    /// Gives a motor a target from now on; without motors there is none to take it.
    pub(crate) fn aim(&mut self, motor: usize, value: f64) {
        if let RunIntegrator::Eventful(eventful) = self {
            eventful.aim(motor, value);
        }
    }

    fn inner(&self) -> &dyn Integrator {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.as_ref(),
            RunIntegrator::OnOtherTree(other) => other.as_ref(),
            RunIntegrator::Eventful(eventful) => eventful.as_ref(),
        }
    }

    fn inner_mut(&mut self) -> &mut dyn Integrator {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.as_mut(),
            RunIntegrator::OnOtherTree(other) => other.as_mut(),
            RunIntegrator::Eventful(eventful) => eventful.as_mut(),
        }
    }
}

impl Integrator for RunIntegrator {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        self.inner_mut().step(mechanism, inputs, state, until)
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.inner_mut().dense(mechanism, time, position, velocity);
    }

    fn bodies(&self) -> Option<&[BodyState]> {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.bodies(),
            RunIntegrator::OnOtherTree(_) | RunIntegrator::Eventful(_) => None,
        }
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

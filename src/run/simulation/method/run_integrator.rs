//! The integrator of a run: the scheme alone, or with events if the mechanism has limits, dry friction, motors or contacts.

use crate::events::Eventful;
use crate::events::crowded::CrowdsSoFar;
use crate::instant::holding::locked::Locked;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::integrator::Integrator;
use crate::simulation::method::held::Held;
use crate::simulation::method::run_steps::RunSteps;
use crate::simulation::method::without_locked::WithoutLocked;
use crate::stepping::integrator::{Lobatto, MethodError};
use crate::stepping::recipe::{Recipe, Steps};
use crate::stepping::trees::other_tree::OnOtherTree;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The integrator of a run, or of an island.
pub struct RunIntegrator(Box<dyn RunSteps>);

impl Clone for RunIntegrator {
    fn clone(&self) -> Self {
        RunIntegrator(self.0.duplicate())
    }
}

impl Deref for RunIntegrator {
    type Target = dyn RunSteps;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl DerefMut for RunIntegrator {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut *self.0
    }
}

impl From<Lobatto> for RunIntegrator {
    fn from(lobatto: Lobatto) -> Self {
        RunIntegrator(Box::new(lobatto))
    }
}

impl RunIntegrator {
    /// The integrator for a mechanism, with these steps; `kept` are the rules that are switched off.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn new(mechanism: &Mechanism, steps: Steps, kept: &[Rule]) -> Result<Self, MethodError> {
        Self::of(mechanism, Recipe::new(steps, kept.to_vec()))
    }

    /// The integrator for a mechanism, made by a recipe.
    ///
    /// # Errors
    /// As of [`RunIntegrator::new`].
    pub(crate) fn of(mechanism: &Mechanism, recipe: Recipe) -> Result<Self, MethodError> {
        let locked = if recipe.kept.contains(&Rule::Locked) { None } else { Locked::of(mechanism) };
        if let Some(locked) = locked {
            let inside = RunIntegrator::of(locked.mechanism(), recipe)?.0;
            return Ok(RunIntegrator(Box::new(WithoutLocked::new(mechanism, locked, inside))));
        }
        if let Steps::Fixed { stages: Eventful::STAGES_OVER_EVENTS, step } = recipe.steps {
            return Ok(RunIntegrator(Box::new(Eventful::over_events(mechanism, step, &recipe.kept)?)));
        }
        if !mechanism.nonsmooth.is_empty() {
            return Ok(RunIntegrator(Box::new(Eventful::new(mechanism, recipe)?)));
        }
        Ok(RunIntegrator(match OnOtherTree::new(mechanism, &[], &recipe)? {
            Some(other) => Box::new(other),
            None => Box::new(recipe.lobatto(mechanism)?),
        }))
    }

    /// The same from a state in which the closures were counted already.
    #[must_use]
    pub fn counted(mut self, counted: Option<Arc<Counted>>) -> Self {
        self.take_counted(counted);
        self
    }

    /// The same for a program that asks for every step.
    #[must_use]
    pub(crate) fn asked_for(mut self) -> Self {
        self.events_mut().into_iter().for_each(Eventful::expect_to_be_asked);
        self
    }

    /// It as an integrator.
    pub fn into_integrator(self) -> Box<dyn Integrator> {
        self.0
    }

    /// From now on no step can be accurate: runs that differ by roundings have met other events.
    pub(crate) fn pass_horizon(&mut self) {
        self.events_mut().into_iter().for_each(Eventful::pass_horizon);
    }

    /// What it has seen of crowds of events.
    pub(crate) fn crowds_so_far(&self) -> Option<CrowdsSoFar> {
        self.events().map(Eventful::crowds_so_far)
    }

    /// Goes on from what another run has seen of crowds.
    pub(crate) fn go_on_from(&mut self, before: Option<CrowdsSoFar>) {
        if let (Some(events), Some(before)) = (self.events_mut(), before) {
            events.go_on_from(before);
        }
    }

    /// The error of the run is estimated.
    pub(crate) fn keep_estimate(&mut self) {
        self.events_mut().into_iter().for_each(Eventful::keep_estimate);
    }

    /// Once a flag that is shared is set, no step is made to its end that is long in work.
    pub(crate) fn heed_interrupt(&mut self, interrupt: Option<&Held<AtomicBool>>) {
        if let (Some(Held::Shared(flag)), Some(events)) = (interrupt, self.events_mut()) {
            events.heed_interrupt(flag.clone());
        }
    }

    /// A bound of the overlap of shapes in the steps so far (m).
    pub(crate) fn overlap(&self) -> f64 {
        self.events().map_or(0.0, Eventful::overlap)
    }

    /// Lets accumulating impacts leave this part of the height that they may leave, and at least this multiple of the least height.
    #[must_use]
    pub(crate) fn leaving(mut self, part: f64, least: f64) -> Self {
        self.events_mut().into_iter().for_each(|events| events.leave_of_impacts(part, least));
        self
    }

    /// Makes steps over events and jams longer by a factor, as in a run with which another is compared.
    pub(crate) fn coarsen_over_events(&mut self, factor: f64) {
        self.events_mut().into_iter().for_each(|events| events.coarsen_over_events(factor));
    }

    /// The sums of the squared lengths of steps over events (s²), and of the lengths of steps over jams (s) so far, to which the errors that they add are
    /// in proportion.
    pub(crate) fn smeared(&self) -> [f64; 2] {
        self.events().map_or([0.0; 2], Eventful::smeared)
    }

    /// The distance by which flights that were left out of accumulating impacts, single steps of first order, and laws that were not solved can have moved
    /// bodies or joints up to an instant (s) (m or rad).
    pub(crate) fn error_of_impacts(&self, time: f64) -> f64 {
        self.events().map_or(0.0, |events| events.error_of_impacts(time))
    }

    /// The distance by which blows in flights that were left out can have moved them up to an instant (s) (m or rad).
    pub(crate) fn doubt_of_blows(&self, time: f64) -> f64 {
        self.events().map_or(0.0, |events| events.doubt_of_blows(time))
    }
}

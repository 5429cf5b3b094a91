//! The integrator of a run: the scheme alone, or with events if the mechanism has limits, dry friction, motors or contacts.

use crate::events::Eventful;
use crate::instant::holding::locked::Locked;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::distance::{probes, probes_of_bodies};
use crate::mechanism::motion::event::{Event, JointStatus};
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Cost, Integrator, MethodDescription, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::method::without_locked::WithoutLocked;
use crate::stepping::integrator::{Lobatto, MethodError};
use crate::stepping::recipe::{Recipe, Steps};
use crate::stepping::trees::other_tree::OnOtherTree;
use nalgebra::Vector3;
use std::sync::Arc;

/// The integrator of a run, or of an island.
#[derive(Clone)]
pub enum RunIntegrator {
    /// The integrator of a smooth motion.
    Smooth(Box<Lobatto>),
    /// The integrator of a smooth motion on another spanning tree than the file's.
    OnOtherTree(Box<OnOtherTree>),
    /// The integrator of a motion with events.
    Eventful(Box<Eventful>),
    /// Of one with locked joints, which no step knows.
    WithoutLocked(Box<WithoutLockedRun>),
}

/// The integrator of the joints that are not locked.
#[derive(Clone)]
pub struct WithoutLockedRun(WithoutLocked<RunIntegrator>);

impl From<Lobatto> for RunIntegrator {
    fn from(lobatto: Lobatto) -> Self {
        RunIntegrator::Smooth(Box::new(lobatto))
    }
}

impl RunIntegrator {
    /// The integrator for a mechanism, with these steps; `kept` are the rules that are switched off.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn new(mechanism: &Mechanism, steps: Steps, kept: &[Rule]) -> Result<Self, MethodError> {
        let locked = if kept.contains(&Rule::Locked) { None } else { Locked::of(mechanism) };
        if let Some(locked) = locked {
            let inside = RunIntegrator::new(locked.mechanism(), steps, kept)?;
            let without = WithoutLocked::new(mechanism, locked, inside);
            return Ok(RunIntegrator::WithoutLocked(Box::new(WithoutLockedRun(without))));
        }
        let recipe = Recipe { steps, kept: kept.to_vec() };
        if !mechanism.nonsmooth.is_empty() {
            return Ok(RunIntegrator::Eventful(Box::new(Eventful::new(mechanism, recipe)?)));
        }
        Ok(match OnOtherTree::new(mechanism, &[], &recipe)? {
            Some(other) => RunIntegrator::OnOtherTree(Box::new(other)),
            None => RunIntegrator::Smooth(Box::new(recipe.lobatto(mechanism)?)),
        })
    }

    /// The same from a state in which the closures were counted already. Events and limits hold joints, which leaves other mechanisms: they count
    /// anew, and so does another spanning tree.
    #[must_use]
    pub fn counted(self, counted: Option<Arc<Counted>>) -> Self {
        match self {
            RunIntegrator::Smooth(lobatto) => RunIntegrator::from(lobatto.counted(counted)),
            RunIntegrator::Eventful(_) | RunIntegrator::OnOtherTree(_) | RunIntegrator::WithoutLocked(_) => self,
        }
    }

    /// Does what the first step from a state and under these inputs begins with, so that copies have it in common; `false` for integrators that
    /// begin with little.
    pub(crate) fn begin(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &mut State) -> bool {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.begin_at(mechanism, inputs, state),
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) | RunIntegrator::WithoutLocked(_) => false,
        }
    }

    /// Whether a step that was to be chosen for its accuracy was shortened for the stability of the scheme.
    pub fn was_held_by_stability(&self) -> bool {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.was_held_by_stability(),
            RunIntegrator::OnOtherTree(other) => other.was_held_by_stability(),
            RunIntegrator::Eventful(eventful) => eventful.was_held_by_stability(),
            RunIntegrator::WithoutLocked(run) => run.0.inside.was_held_by_stability(),
        }
    }

    /// The error of samples inside the steps so far, beside the error of their ends (m); `None` if it is not known.
    pub(crate) fn between(&self) -> Option<f64> {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.between(),
            RunIntegrator::OnOtherTree(other) => other.between(),
            RunIntegrator::Eventful(eventful) => eventful.between(),
            RunIntegrator::WithoutLocked(run) => run.0.inside.between(),
        }
    }

    /// From now on no step can be accurate: runs that differ by roundings have met other events.
    pub(crate) fn pass_horizon(&mut self) {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.pass_horizon(),
            RunIntegrator::WithoutLocked(run) => run.0.inside.pass_horizon(),
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) => {}
        }
    }

    /// The error of the run is estimated.
    pub(crate) fn keep_estimate(&mut self) {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.keep_estimate(),
            RunIntegrator::WithoutLocked(run) => run.0.inside.keep_estimate(),
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) => {}
        }
    }

    /// A bound of the overlap of shapes in the steps so far (m).
    pub(crate) fn overlap(&self) -> f64 {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.overlap(),
            RunIntegrator::WithoutLocked(run) => run.0.inside.overlap(),
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) => 0.0,
        }
    }

    /// Whether forces inside their cones are known to hold all closed contacts in the state at the end of the last step.
    pub(crate) fn holds_all(&self, state: &State) -> bool {
        matches!(self, RunIntegrator::Eventful(eventful) if eventful.holds_all(state))
    }

    /// Lets accumulating impacts leave this part of the height that they may leave, and at least this multiple of the least height.
    #[must_use]
    pub(crate) fn leaving(mut self, part: f64, least: f64) -> Self {
        self.leave_of_impacts(part, least);
        self
    }

    fn leave_of_impacts(&mut self, part: f64, least: f64) {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.leave_of_impacts(part, least),
            RunIntegrator::WithoutLocked(run) => run.0.inside.leave_of_impacts(part, least),
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) => {}
        }
    }

    /// Makes steps over events and jams longer by a factor, as in a run with which another is compared.
    pub(crate) fn coarsen_over_events(&mut self, factor: f64) {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.coarsen_over_events(factor),
            RunIntegrator::WithoutLocked(run) => run.0.inside.coarsen_over_events(factor),
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) => {}
        }
    }

    /// The sums of the squared lengths of steps over events (s²), and of the lengths of steps over jams (s) so far, to which the errors that they add are
    /// in proportion.
    pub(crate) fn smeared(&self) -> [f64; 2] {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.smeared(),
            RunIntegrator::WithoutLocked(run) => run.0.inside.smeared(),
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) => [0.0; 2],
        }
    }

    /// The distance by which flights that were left out of accumulating impacts, and single steps of first order, can have moved bodies or joints so far
    /// (m or rad).
    pub(crate) fn error_of_impacts(&self) -> f64 {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.error_of_impacts(),
            RunIntegrator::WithoutLocked(run) => run.0.inside.error_of_impacts(),
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) => 0.0,
        }
    }

    /// The distance by which blows in flights that were left out can have moved them up to an instant (s) (m or rad).
    pub(crate) fn doubt_of_blows(&self, time: f64) -> f64 {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.doubt_of_blows(time),
            RunIntegrator::WithoutLocked(run) => run.0.inside.doubt_of_blows(time),
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) => 0.0,
        }
    }

    /// The largest error of samples inside steps that were too long for a damper (m), which the errors at the ends of the steps do not include.
    pub(crate) fn ringing_inside(&self) -> f64 {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.ringing_inside(),
            RunIntegrator::Eventful(eventful) => eventful.ringing_inside(),
            RunIntegrator::WithoutLocked(run) => run.0.inside.ringing_inside(),
            // In a scene with closed loops, a run beside this one has steps of its own.
            RunIntegrator::OnOtherTree(_) => 0.0,
        }
    }

    /// Carries a companion from the first step on, where that tells the errors of the steps: until the first event, if there are any; returns whether
    /// it does.
    pub(crate) fn accompany(&mut self, mechanism: &Mechanism) -> bool {
        match self {
            _ if mechanism.has_closures() => return false,
            RunIntegrator::Smooth(lobatto) => lobatto.accompany(mechanism),
            RunIntegrator::Eventful(eventful) => eventful.accompany(),
            RunIntegrator::WithoutLocked(run) => {
                let own = run.0.mechanism().clone();
                return run.0.inside.accompany(&own);
            }
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
            RunIntegrator::WithoutLocked(run) => run.0.inside.leave_companion(),
            RunIntegrator::OnOtherTree(_) => {}
        }
    }

    /// Its probes after the last step, which has left the run in `state`; `None` without a companion.
    pub(crate) fn companion_probes(&self, mechanism: &Mechanism, state: &State) -> Option<Vec<Vector3<f64>>> {
        match self {
            RunIntegrator::Smooth(lobatto) => {
                let companion = lobatto.companion()?;
                let placed = lobatto.companion_bodies().map(|bodies| probes_of_bodies(mechanism, bodies));
                Some(placed.unwrap_or_else(|| probes(mechanism, companion.state())))
            }
            RunIntegrator::Eventful(_) | RunIntegrator::WithoutLocked(_) => {
                let mut there = state.clone();
                self.place_companion(&mut there).then(|| probes(mechanism, &there))
            }
            RunIntegrator::OnOtherTree(_) => None,
        }
    }

    /// Writes the state of the companion after the last step, which has left the run in `state`; `false` without a companion.
    fn place_companion(&self, state: &mut State) -> bool {
        match self {
            RunIntegrator::Smooth(lobatto) => match lobatto.companion() {
                Some(companion) => {
                    state.copy_from(companion.state());
                    true
                }
                None => false,
            },
            RunIntegrator::Eventful(eventful) => eventful.place_companion(state),
            RunIntegrator::WithoutLocked(run) => run.0.change(state, |own| run.0.inside.place_companion(own)),
            RunIntegrator::OnOtherTree(_) => false,
        }
    }

    /// Gives a motor a target from now on; without motors there is none to take it.
    pub(crate) fn aim(&mut self, motor: usize, value: f64) {
        match self {
            RunIntegrator::Eventful(eventful) => eventful.aim(motor, value),
            RunIntegrator::WithoutLocked(run) => {
                if let Some(own) = run.0.motor(motor) {
                    run.0.inside.aim(own, value);
                }
            }
            RunIntegrator::Smooth(_) | RunIntegrator::OnOtherTree(_) => {}
        }
    }

    fn inner(&self) -> &dyn Integrator {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.as_ref(),
            RunIntegrator::OnOtherTree(other) => other.as_ref(),
            RunIntegrator::Eventful(eventful) => eventful.as_ref(),
            RunIntegrator::WithoutLocked(run) => &run.0,
        }
    }

    fn inner_mut(&mut self) -> &mut dyn Integrator {
        match self {
            RunIntegrator::Smooth(lobatto) => lobatto.as_mut(),
            RunIntegrator::OnOtherTree(other) => other.as_mut(),
            RunIntegrator::Eventful(eventful) => eventful.as_mut(),
            RunIntegrator::WithoutLocked(run) => &mut run.0,
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
            RunIntegrator::OnOtherTree(_) | RunIntegrator::Eventful(_) | RunIntegrator::WithoutLocked(_) => None,
        }
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

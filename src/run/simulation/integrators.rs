//! The integrators of a run: one for the whole mechanism, or one for each island that moves.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription};
use crate::mechanism::motion::state::State;
use crate::mechanism::structure::islands::{first_of_parts, groups};
use crate::simulation::method::held::Held;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::method::step_choice::StepChoice;
use crate::simulation::parallel::groups::{Begins, Groups};
use crate::simulation::parallel::islands::Islands;
use crate::simulation::parallel::partition::Plan;
use crate::simulation::parallel::threads::Threads;
use crate::simulation::tolerance::accuracy::{Accuracy, UnknownAccuracy};
use crate::simulation::tolerance::estimated_run::EstimatedRun;
use crate::simulation::tolerance::terms::{Terms, first_stop};
use crate::stepping::integrator::MethodError;
use crate::stepping::length::stage_choice::StageChoice;
use crate::stepping::recipe::Steps;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Islands of fewer bodies are integrated together: where their steps would be the same, and where each would have its own (`cargo bench --bench
/// islands`).
const SMALLEST: usize = 20;
const SMALLEST_OF_OWN_STEPS: usize = 10;
/// Scenes of more parts that may touch are one group.
const MOST_PARTS: usize = 64;

/// Why a run cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// The stages or the step are invalid.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The mechanism is invalid.
    #[error(transparent)]
    Mechanism(#[from] MechanismError),
}

/// The integrators. A mechanism of one island that moves is not a list of one: its samples show the figures at the end of the last step, in
/// logs and pages, and the samples of several islands, whose steps end at no common instant, show the figures of their own instant. A chain of
/// 20 links alone and beside a pendulum at rest has the same motion to the last bit, and kinetic energies at samples up to 308 J apart, of 5411
/// J (1 s).
pub(crate) enum Integrators<'a> {
    Whole(EstimatedRun<'a>),
    Islands {
        islands: Box<Islands<'a>>,
        /// The description of the method while all islands sleep.
        idle: Box<MethodDescription>,
    },
}

/// The accuracies so far: one entry per integrator.
pub(crate) type Accuracies = Vec<Result<Accuracy, UnknownAccuracy>>;

/// The settings of the steps of a run.
pub(crate) struct Wanted<'a> {
    pub choice: StepChoice,
    /// Simulated time (s).
    pub duration: f64,
    /// A flag that ends the run beside it when it is set.
    pub interrupt: Option<Held<'a, AtomicBool>>,
    /// The ranks of the closures of the whole mechanism at the start.
    pub counted: Option<Arc<Counted>>,
    /// Whether a program makes its steps, and may change it between them: it makes no estimate of its error.
    pub stepped: bool,
}

impl<'a> Integrators<'a> {
    /// Chooses the integrators.
    ///
    /// # Errors
    /// [`SimulationError`] for invalid stages and steps.
    pub fn new(
        mechanism: &Mechanism,
        state: &State,
        plan: Plan,
        wanted: &Wanted<'a>,
    ) -> Result<(Self, Accuracies), SimulationError> {
        let choice = wanted.choice;
        if let Some(in_groups) = Self::in_groups(mechanism, state, &plan, wanted)? {
            return Ok(in_groups);
        }
        let plan = plan.grouped(
            mechanism,
            match choice {
                StepChoice::Fixed { .. } | StepChoice::Precise { .. } => SMALLEST,
                StepChoice::Tolerance(_) | StepChoice::Unestimated(_) | StepChoice::Reversible { .. } => {
                    SMALLEST_OF_OWN_STEPS
                }
            },
        );
        let kept = plan.kept.clone();
        let make = |mechanism: &Mechanism, state: &State| wanted.integrator(mechanism, state, &kept, None);
        if plan.is_whole() {
            let (integrator, unknown) = wanted.integrator(mechanism, state, &kept, wanted.counted.clone())?;
            return Ok((Integrators::Whole(integrator), vec![Err(unknown)]));
        }
        let idle = idle(mechanism, choice)?;
        let (islands, unknown) = Islands::new(plan, state, Threads::WherePaid, make)?;
        Ok((Integrators::Islands { islands: Box::new(islands), idle }, unknown.into_iter().map(Err).collect()))
    }

    /// The integrators of groups of bodies that form and fall apart, if several bodies of a mechanism touch others now and then, and steps are chosen.
    fn in_groups(
        mechanism: &Mechanism,
        state: &State,
        plan: &Plan,
        wanted: &Wanted<'a>,
    ) -> Result<Option<(Self, Accuracies)>, SimulationError> {
        let Some(tolerance) = wanted.choice.tolerance().filter(|_| !wanted.stepped) else { return Ok(None) };
        let parts = parts_count(mechanism);
        if plan.kept.contains(&Rule::Islands) || parts <= plan.islands.len() || parts > MOST_PARTS {
            return Ok(None);
        }
        let terms = wanted.terms(tolerance, state, &plan.kept, None);
        let make = move |mechanism: &Mechanism, begins: Begins| {
            // Events hold joints, which changes the mechanism.
            let terms = terms.clone();
            match begins {
                Begins::First(None) => EstimatedRun::new(mechanism, terms),
                Begins::First(Some(fineness)) => EstimatedRun::as_fine_as(mechanism, terms, fineness),
                Begins::GoingOn(handed) => EstimatedRun::going_on(mechanism, terms, *handed),
            }
        };
        let Some(present) = Groups::new(mechanism, state, Box::new(make)) else { return Ok(None) };
        let plan = Plan::of(groups(mechanism, present.groups()), state, &plan.kept, None);
        let make = |mechanism: &Mechanism, _: &State| Ok((present.first(mechanism, None)?, UnknownAccuracy::NotYet));
        let (islands, unknown) = Islands::new::<_, _, MethodError>(plan, state, Threads::WherePaid, make)?;
        let (islands, idle) = (Box::new(islands.regrouped(present)), idle(mechanism, wanted.choice)?);
        Ok(Some((Integrators::Islands { islands, idle }, unknown.into_iter().map(Err).collect())))
    }

    /// Calls a function with each integrator, and its state.
    fn each(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        mut work: impl FnMut(&Mechanism, &State, &mut EstimatedRun),
    ) {
        match self {
            Integrators::Whole(run) => work(mechanism, state, run),
            Integrators::Islands { islands, .. } => islands.each(work),
        }
    }

    /// Prepares a restart from a state: finer steps for the islands that were too coarse, and the same steps for the others.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub fn begin_again(&mut self, mechanism: &Mechanism, state: &State) -> Result<(), MethodError> {
        if let Integrators::Islands { islands, .. } = self
            && islands.are_regrouped()
        {
            return islands.begin_groups_again(mechanism, state);
        }
        let mut prepared = Ok(());
        self.each(mechanism, state, |mechanism, _, run| {
            if prepared.is_ok() {
                prepared = run.begin_again(mechanism);
            }
        });
        prepared
    }

    /// Puts groups that form and fall apart together for good, before their first step: a program may change their run at any time.
    pub fn join_groups(&mut self, mechanism: &Mechanism) {
        // Steps that are valid for the groups are valid for the whole.
        if let Integrators::Islands { islands, .. } = self
            && let Some(Ok(whole)) = islands.joined(mechanism)
        {
            *self = Integrators::Whole(whole);
        }
    }

    /// Forbids restarts from now on, whatever the errors.
    pub fn settle(&mut self, mechanism: &Mechanism, state: &State) {
        self.each(mechanism, state, |_, _, run| run.settle());
    }

    /// The run's own error estimates up to a state: one entry per integrator that makes one.
    pub fn told(&mut self, mechanism: &Mechanism, state: &State) -> Accuracies {
        let mut all = Vec::new();
        self.each(mechanism, state, |mechanism, state, run| all.extend(run.accuracy(mechanism, state)));
        all
    }

    /// The method of the steps and its figures so far.
    pub fn description(&self) -> MethodDescription {
        match self {
            Integrators::Whole(integrator) => integrator.description(),
            Integrators::Islands { islands, idle } => islands.description().unwrap_or_else(|| (**idle).clone()),
        }
    }
}

/// How many parts of a mechanism only pairs of shapes can bring together.
fn parts_count(mechanism: &Mechanism) -> usize {
    first_of_parts(mechanism).iter().enumerate().filter(|(body, first)| body == *first).count()
}

/// The description of a method that has nothing to do.
fn idle(mechanism: &Mechanism, choice: StepChoice) -> Result<Box<MethodDescription>, SimulationError> {
    let nothing = Mechanism::new(&mechanism.name, mechanism.gravity, Vec::new())?;
    Ok(Box::new(choice.integrator(&nothing, &[])?.description()))
}

impl<'a> Wanted<'a> {
    /// Chooses an integrator (the only place that does), and says why its accuracy is not known yet.
    fn integrator(
        &self,
        mechanism: &Mechanism,
        state: &State,
        kept: &[Rule],
        counted: Option<Arc<Counted>>,
    ) -> Result<(EstimatedRun<'a>, UnknownAccuracy), SimulationError> {
        // Events hold joints, which changes the mechanism.
        let counts = mechanism.has_closures() && mechanism.nonsmooth.is_empty();
        let counted = counted.or_else(|| counts.then(|| Arc::new(Counted::at(mechanism, state))));
        let Some(tolerance) = self.choice.tolerance() else {
            let mut given = self.choice.integrator(mechanism, kept)?.counted(counted);
            given.heed_interrupt(self.interrupt.as_ref());
            return Ok((given.into(), UnknownAccuracy::NotAsked));
        };
        if self.stepped {
            let (stop, stages) = (first_stop(mechanism, tolerance), StageChoice::of(mechanism, tolerance));
            let mut run = RunIntegrator::new(mechanism, Steps::Chosen { tolerance, stop, stages }, kept)?.asked_for();
            run.heed_interrupt(self.interrupt.as_ref());
            return Ok((run.counted(counted).into(), UnknownAccuracy::Stepped));
        }
        let terms = self.terms(tolerance, state, kept, counted);
        Ok((EstimatedRun::new(mechanism, terms)?, UnknownAccuracy::NotYet))
    }

    /// The settings of a run with a tolerance.
    fn terms(&self, tolerance: f64, state: &State, kept: &[Rule], counted: Option<Arc<Counted>>) -> Terms<'a> {
        Terms {
            tolerance,
            start: state.time,
            end: state.time + self.duration,
            kept: kept.to_vec(),
            counted,
            interrupt: self.interrupt.clone(),
            estimate: !matches!(self.choice, StepChoice::Unestimated(_)),
            over_events: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::motion::inputs::Inputs;
    use nalgebra::Vector3;
    use std::sync::atomic::Ordering;

    #[test]
    fn given_steps_over_events_are_given_up_once_the_run_is_interrupted() {
        let joint = Joint::new("ball", JointKind::Floating, Pose::identity(), Pose::identity());
        let body = Body { name: "ball".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(4e-3), joint };
        let mut mechanism = Mechanism::new("ball", Vector3::z() * -9.81, vec![body]).expect("a body that moves");
        let shapes = [(Some(0), Shape::Sphere { radius: 0.1 }), (None, Shape::HalfSpace)];
        let shapes = shapes.map(|(body, shape)| Collider::still("one", body, Pose::identity(), shape));
        mechanism.nonsmooth.colliders.extend(shapes);
        mechanism.nonsmooth.pairs.push(ContactPair::without_moments(0, [0, 1], 0.5, 0.0));
        let mut state = State::zero(&mechanism);
        state.position[2] = 1.0;
        let flag = Arc::new(AtomicBool::new(false));
        let choice = StepChoice::Fixed { stages: StepChoice::OVER_EVENTS, step: 1e-3 };
        let interrupt = Some(Held::Shared(flag.clone()));
        let wanted = Wanted { choice, duration: 1.0, interrupt, counted: None, stepped: false };
        let (mut run, _) = wanted.integrator(&mechanism, &state, &[], None).expect("possible steps");
        let inputs = Inputs::constant(&[0.0; 6]);
        let mut step = |state: &mut State| run.step(&mechanism, inputs, state, 1.0).expect("a step").step;
        assert_eq!(step(&mut state), 1e-3);
        flag.store(true, Ordering::Relaxed);
        assert_eq!((step(&mut state), state.time), (0.0, 1e-3));
    }
}

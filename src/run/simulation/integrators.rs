//! The integrators of a run: one for the whole mechanism, or one for each island that moves.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription};
use crate::mechanism::motion::state::State;
use crate::simulation::method::held::Held;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::method::step_choice::StepChoice;
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
        islands: Islands<'a>,
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
        let nothing = Mechanism::new(&mechanism.name, mechanism.gravity, Vec::new())?;
        let idle = Box::new(choice.integrator(&nothing, &[])?.description());
        let (islands, unknown) = Islands::new(plan, state, Threads::WherePaid, make)?;
        Ok((Integrators::Islands { islands, idle }, unknown.into_iter().map(Err).collect()))
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
        let mut prepared = Ok(());
        self.each(mechanism, state, |mechanism, _, run| {
            if prepared.is_ok() {
                prepared = run.begin_again(mechanism);
            }
        });
        prepared
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
            let given = self.choice.integrator(mechanism, kept)?.counted(counted);
            return Ok((given.into(), UnknownAccuracy::NotAsked));
        };
        if self.stepped {
            let (stop, stages) = (first_stop(mechanism, tolerance), StageChoice::of(mechanism, tolerance));
            let mut run = RunIntegrator::new(mechanism, Steps::Chosen { tolerance, stop, stages }, kept)?.asked_for();
            run.heed_interrupt(self.interrupt.as_ref());
            return Ok((run.counted(counted).into(), UnknownAccuracy::Stepped));
        }
        let estimate = !matches!(self.choice, StepChoice::Unestimated(_));
        let (start, end) = (state.time, state.time + self.duration);
        let terms = Terms {
            tolerance,
            start,
            end,
            kept: kept.to_vec(),
            counted,
            interrupt: self.interrupt.clone(),
            estimate,
            over_events: 1.0,
        };
        Ok((EstimatedRun::new(mechanism, terms)?, UnknownAccuracy::NotYet))
    }
}

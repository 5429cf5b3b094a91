//! The integrators of a run: one for the whole mechanism, or one for each island that moves; calibrated if there is a tolerance.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::method::step_choice::StepChoice;
use crate::simulation::parallel::islands::Islands;
use crate::simulation::parallel::partition::Plan;
use crate::simulation::parallel::threads::Threads;
use crate::simulation::steps::making::Making;
use crate::simulation::tolerance::accuracy::{Calibration, UnknownAccuracy, calibrate_counted};
use crate::simulation::tolerance::assessed::Assessed;
use crate::simulation::tolerance::terms::{Terms, first_stop};
use crate::simulation::tolerance::trial_run::CalibrationError;
use crate::stepping::integrator::MethodError;
use crate::stepping::length::stage_choice::StageChoice;
use crate::stepping::recipe::Steps;
use cpu_time::ThreadTime;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A lower bound of the CPU time of a trial run for each body and simulated second (s).
const TRIAL_SECONDS: f64 = 5e-6;

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
    /// The run was interrupted during the trial runs for its accuracy.
    #[error(transparent)]
    Interrupted(CalibrationError),
    /// The mechanism is invalid.
    #[error(transparent)]
    Mechanism(#[from] MechanismError),
}

/// The integrators.
pub(crate) enum Integrators<'a> {
    Whole(Making<'a>),
    Islands {
        islands: Islands<'a>,
        /// The description of the method while all islands sleep.
        idle: Box<MethodDescription>,
    },
}

/// The results of calibration: one entry per integrator.
pub(crate) type Calibrations = Vec<Result<Calibration, UnknownAccuracy>>;

/// Who estimates the error of a run with a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Estimate {
    /// Trial runs before it, which calibrate its steps.
    Trials,
    /// The run itself, which may restart.
    Itself,
    /// Neither: a program makes its steps, and may change it between them.
    Missing,
}

/// The settings of the steps of a run.
pub(crate) struct Wanted<'a> {
    pub choice: StepChoice,
    /// Simulated time (s).
    pub duration: f64,
    /// A flag that ends the runs when it is set.
    pub interrupt: Option<&'a AtomicBool>,
    /// The ranks of the closures of the whole mechanism at the start.
    pub counted: Option<Arc<Counted>>,
    /// Who estimates the error of a run with a tolerance.
    pub estimate: Estimate,
    /// CPU time of trial runs (s).
    pub spent: Mutex<f64>,
}

impl<'a> Integrators<'a> {
    /// Chooses the integrators, and calibrates them for a tolerance.
    ///
    /// # Errors
    /// [`SimulationError`] for invalid stages and steps, and when interrupted.
    pub fn new(
        mechanism: &Mechanism,
        state: &State,
        plan: Plan,
        wanted: &Wanted<'a>,
    ) -> Result<(Self, Calibrations), SimulationError> {
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
            let (integrator, found) = wanted.integrator(mechanism, state, &kept, wanted.counted.clone())?;
            return Ok((Integrators::Whole(integrator), vec![found]));
        }
        let trials = if choice.tolerance().is_some() { 2.0 } else { 0.0 };
        let expected = trials * TRIAL_SECONDS * mechanism.bodies.len() as f64 * wanted.duration;
        let nothing = Mechanism::new(&mechanism.name, mechanism.gravity, Vec::new())?;
        let idle = Box::new(choice.integrator(&nothing, &[])?.description());
        let (islands, found) = Islands::new(plan, state, Threads::WherePaid, expected, make)?;
        Ok((Integrators::Islands { islands, idle }, found))
    }

    /// Calls a function with each integrator that estimates its error, and its state.
    fn each_telling(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        mut work: impl FnMut(&Mechanism, &State, &mut Assessed),
    ) {
        match self {
            Integrators::Whole(integrator) => {
                integrator.telling().into_iter().for_each(|assessed| work(mechanism, state, assessed));
            }
            Integrators::Islands { islands, .. } => islands.each_telling(work),
        }
    }

    /// Prepares a restart from a state: finer steps for the islands that were too coarse, and the same steps for the others.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub fn begin_again(&mut self, mechanism: &Mechanism, state: &State) -> Result<(), MethodError> {
        let mut prepared = Ok(());
        self.each_telling(mechanism, state, |mechanism, _, assessed| {
            if prepared.is_ok() {
                prepared = assessed.begin_again(mechanism);
            }
        });
        prepared
    }

    /// Forbids restarts from now on, whatever the errors.
    pub fn settle(&mut self, mechanism: &Mechanism, state: &State) {
        self.each_telling(mechanism, state, |_, _, assessed| assessed.settle());
    }

    /// The run's own error estimates up to a state: one entry per integrator.
    pub fn told(&mut self, mechanism: &Mechanism, state: &State) -> Calibrations {
        let mut all = Vec::new();
        self.each_telling(mechanism, state, |mechanism, state, assessed| all.push(assessed.accuracy(mechanism, state)));
        all
    }

    /// The error of samples inside the steps, as integrators without an estimate of their own know it (m): one entry for each.
    pub fn between(&self) -> Vec<Option<f64>> {
        match self {
            Integrators::Whole(integrator) => vec![integrator.between()],
            Integrators::Islands { islands, .. } => islands.between(),
        }
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
    /// Chooses an integrator (the only place that does); calibrates it if there is a tolerance.
    fn integrator(
        &self,
        mechanism: &Mechanism,
        state: &State,
        kept: &[Rule],
        counted: Option<Arc<Counted>>,
    ) -> Result<(Making<'a>, Result<Calibration, UnknownAccuracy>), SimulationError> {
        // Events hold joints, which changes the mechanism.
        let counts = mechanism.has_closures() && mechanism.nonsmooth.is_empty();
        let counted = counted.or_else(|| counts.then(|| Arc::new(Counted::at(mechanism, state))));
        let uncalibrated = || Ok::<_, MethodError>(self.choice.integrator(mechanism, kept)?.counted(counted.clone()));
        let Some(tolerance) = self.choice.tolerance() else {
            return Ok((uncalibrated()?.into(), Err(UnknownAccuracy::NotAsked)));
        };
        if self.estimate == Estimate::Missing {
            let (stop, stages) = (first_stop(mechanism, tolerance), StageChoice::of(mechanism, tolerance));
            let run = RunIntegrator::new(mechanism, Steps::Chosen { tolerance, stop, stages }, kept)?;
            return Ok((run.counted(counted).into(), Err(UnknownAccuracy::Stepped)));
        }
        let estimate = !matches!(self.choice, StepChoice::Unestimated(_));
        if self.estimate == Estimate::Itself || !estimate {
            let (start, end) = (state.time, state.time + self.duration);
            let kept = kept.to_vec();
            let terms = Terms { tolerance, start, end, kept, counted, interrupt: self.interrupt, estimate };
            let assessed = Assessed::new(mechanism, terms)?;
            return Ok((Making::Telling(Box::new(assessed)), Err(UnknownAccuracy::NotYet)));
        }
        let mut go_on = |_: f64, _: &StepOutcome| !self.interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let clock = ThreadTime::now();
        let found = calibrate_counted(mechanism, state, counted.as_ref(), self.duration, tolerance, kept, &mut go_on);
        *self.spent.lock().unwrap_or_else(PoisonError::into_inner) += clock.elapsed().as_secs_f64();
        match found {
            Ok(found) => Ok((found.run_integrator(mechanism, tolerance, kept)?.counted(counted).into(), Ok(found))),
            Err(interrupted @ CalibrationError::Interrupted) => Err(SimulationError::Interrupted(interrupted)),
            Err(CalibrationError::Method(error)) => Err(SimulationError::Method(error)),
            // The run will fail where the trial run did, with a log up to there.
            Err(CalibrationError::Step(error)) => {
                Ok((uncalibrated()?.into(), Err(UnknownAccuracy::TrialFailed(error))))
            }
        }
    }
}

//! The integrators of a run: one for the whole mechanism, or one for each island that moves; calibrated if there is a tolerance.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::accuracy::{Calibration, UnknownAccuracy, calibrate_counted};
use crate::simulation::assessed::Assessed;
use crate::simulation::islands::Islands;
use crate::simulation::making::Making;
use crate::simulation::partition::Plan;
use crate::simulation::step_choice::StepChoice;
use crate::simulation::terms::Terms;
use crate::simulation::threads::Threads;
use crate::simulation::trial_run::CalibrationError;
use crate::stepping::integrator::MethodError;
use cpu_time::ThreadTime;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// About what a trial run takes for each body and simulated second (s): no less than that, for want of knowing it.
const TRIAL_SECONDS: f64 = 5e-6;

/// Islands of fewer bodies are run together, where their steps are the same and where each would have its own
/// (`cargo bench --bench islands`).
const SMALLEST: usize = 20;
const SMALLEST_OF_OWN_STEPS: usize = 10;

/// Why a run cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// The stages or the step.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The run was interrupted during the trial runs for its accuracy.
    #[error(transparent)]
    Interrupted(CalibrationError),
    /// The mechanism.
    #[error(transparent)]
    Mechanism(#[from] MechanismError),
}

/// What makes the steps.
pub(crate) enum Integrators {
    Whole(Making),
    Islands {
        islands: Islands,
        /// What stands for the method where all sleep.
        idle: Box<MethodDescription>,
    },
}

/// What trial runs have found: one entry for each integrator.
pub(crate) type Calibrations = Vec<Result<Calibration, UnknownAccuracy>>;

/// What is wanted of the steps of a run.
pub(crate) struct Wanted<'w> {
    pub choice: StepChoice,
    /// Simulated time (s).
    pub duration: f64,
    /// Is told the simulated time that a trial run has reached (s).
    pub reached: &'w (dyn Fn(f64) + Sync),
    /// Set from outside to end trial runs.
    pub interrupt: Option<&'w AtomicBool>,
    /// What was counted of the closures of the whole at the start.
    pub counted: Option<Arc<Counted>>,
    /// Whether the run tells its accuracy as it goes along, and may restart; otherwise trial runs tell it before.
    pub at_once: bool,
    /// CPU time that trial runs have taken (s).
    pub spent: Mutex<f64>,
}

impl Integrators {
    /// Chooses the integrators and calibrates a tolerance for the motions at hand.
    ///
    /// # Errors
    /// [`SimulationError`] for stages and steps that cannot be, and when interrupted.
    pub fn new(
        mechanism: &Mechanism,
        state: &State,
        plan: Plan,
        wanted: &Wanted,
    ) -> Result<(Self, Calibrations), SimulationError> {
        let choice = wanted.choice;
        let plan = plan.grouped(
            mechanism,
            match choice {
                StepChoice::Fixed { .. } | StepChoice::Precise { .. } => SMALLEST,
                StepChoice::Tolerance(_) | StepChoice::Reversible { .. } => SMALLEST_OF_OWN_STEPS,
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

    /// Does something with each integrator that tells how far it is off, and where it is.
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

    /// Prepares all of a run that is to restart from a state: the same steps but where they were too coarse.
    ///
    /// # Errors
    /// [`MethodError`] for steps that cannot be.
    pub fn begin_again(&mut self, mechanism: &Mechanism, state: &State) -> Result<(), MethodError> {
        let mut prepared = Ok(());
        self.each_telling(mechanism, state, |mechanism, _, assessed| {
            if prepared.is_ok() {
                prepared = assessed.begin_again(mechanism);
            }
        });
        prepared
    }

    /// Whatever the errors, the run does not restart from now on.
    pub fn settle(&mut self, mechanism: &Mechanism, state: &State) {
        self.each_telling(mechanism, state, |_, _, assessed| assessed.settle());
    }

    /// What the run itself has told of its accuracy up to a state: one entry for each integrator that was to.
    pub fn told(&mut self, mechanism: &Mechanism, state: &State) -> Calibrations {
        let mut all = Vec::new();
        self.each_telling(mechanism, state, |mechanism, state, assessed| all.push(assessed.accuracy(mechanism, state)));
        all
    }

    /// How steps are made, and how they have gone so far.
    pub fn description(&self) -> MethodDescription {
        match self {
            Integrators::Whole(integrator) => integrator.description(),
            Integrators::Islands { islands, idle } => islands.description().unwrap_or_else(|| (**idle).clone()),
        }
    }
}

impl Wanted<'_> {
    /// The one place where an integrator is chosen; a tolerance is calibrated for the motion at hand.
    fn integrator(
        &self,
        mechanism: &Mechanism,
        state: &State,
        kept: &[Rule],
        counted: Option<Arc<Counted>>,
    ) -> Result<(Making, Result<Calibration, UnknownAccuracy>), SimulationError> {
        // Events hold joints, which leaves other mechanisms.
        let counts = mechanism.has_closures() && mechanism.nonsmooth.is_empty();
        let counted = counted.or_else(|| counts.then(|| Arc::new(Counted::at(mechanism, state))));
        let uncalibrated = || Ok::<_, MethodError>(self.choice.integrator(mechanism, kept)?.counted(counted.clone()));
        let Some(tolerance) = self.choice.tolerance() else {
            return Ok((uncalibrated()?.into(), Err(UnknownAccuracy::NotAsked)));
        };
        if self.at_once {
            let (start, end) = (state.time, state.time + self.duration);
            let terms = Terms { tolerance, start, end, kept: kept.to_vec(), counted };
            let assessed = Assessed::new(mechanism, terms)?;
            return Ok((Making::Telling(Box::new(assessed)), Err(UnknownAccuracy::NotYet)));
        }
        let mut go_on = |time: f64, _: &StepOutcome| {
            (self.reached)(time - state.time);
            !self.interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed))
        };
        let clock = ThreadTime::now();
        let found = calibrate_counted(mechanism, state, counted.as_ref(), self.duration, tolerance, kept, &mut go_on);
        *self.spent.lock().unwrap_or_else(PoisonError::into_inner) += clock.elapsed().as_secs_f64();
        match found {
            Ok(found) => Ok((found.run_integrator(mechanism, tolerance, kept)?.counted(counted).into(), Ok(found))),
            Err(interrupted @ CalibrationError::Interrupted) => Err(SimulationError::Interrupted(interrupted)),
            Err(CalibrationError::Method(error)) => Err(SimulationError::Method(error)),
            // The run will fail where the trial run did, and leave its log up to there.
            Err(CalibrationError::Step(error)) => {
                Ok((uncalibrated()?.into(), Err(UnknownAccuracy::TrialFailed(error))))
            }
        }
    }
}

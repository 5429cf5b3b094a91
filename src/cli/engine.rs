//! What makes the steps of `catena simulate` and `catena replay`: the integrators, for the whole or for each island.

use std::sync::atomic::{AtomicBool, Ordering};
use crate::cli::Failure;
use crate::cli::simulate::StepChoice;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::integrator::{Integrator, MethodDescription};
use catena::mechanism::motion::state::State;
use catena::output::report::{AccuracyReport, IslandReport};
use catena::simulation::accuracy::calibrate;
use catena::simulation::trial_run::CalibrationError;
use catena::simulation::islands::{Islands, Plan};
use catena::simulation::threads::Threads;
use catena::simulation::{Observer, RunError, RunOptions, Summary, run as run_simulation};
use catena::stepping::integrator::Lobatto;

/// About what a pilot run takes for each body and simulated second (s): no less than that, for want of knowing it.
const PILOT_SECONDS: f64 = 5e-6;

/// Islands of fewer bodies are run together, where their steps are the same and where each would have its own
/// (`cargo bench --bench islands`).
const SMALLEST: usize = 20;
const SMALLEST_OF_OWN_STEPS: usize = 10;

/// What makes the steps: one integrator for a mechanism that is one and moves, and one for each island otherwise.
pub enum Engine {
    Whole(Box<Lobatto>),
    Islands {
        islands: Islands,
        /// What stands for the method where all sleep.
        idle: Box<MethodDescription>,
    },
}

impl Engine {
    /// Chooses the integrators and calibrates a tolerance for the motions at hand.
    ///
    /// # Errors
    /// [`Failure`] for stages and steps that cannot be, and when interrupted.
    pub fn new(
        mechanism: &Mechanism,
        state: &State,
        duration: f64,
        choice: StepChoice,
        plan: Plan,
        interrupted: &AtomicBool,
    ) -> Result<(Self, Option<AccuracyReport>), Failure> {
        let plan = plan.grouped(
            mechanism,
            match choice {
                StepChoice::Fixed { .. } | StepChoice::Precise { .. } => SMALLEST,
                StepChoice::Tolerance(_) | StepChoice::Reversible { .. } => SMALLEST_OF_OWN_STEPS,
            },
        );
        let kept = plan.kept.clone();
        let make = |mechanism: &Mechanism, state: &State| {
            let (lobatto, accuracy) = integrator(mechanism, state, duration, choice, &kept, interrupted)?;
            Ok((lobatto.keeping(mechanism, &kept), accuracy))
        };
        if plan.is_whole() {
            let (lobatto, accuracy) = make(mechanism, state)?;
            return Ok((Engine::Whole(Box::new(lobatto)), accuracy));
        }
        let pilots = if choice.tolerance().is_some() { 2.0 } else { 0.0 };
        let expected = pilots * PILOT_SECONDS * mechanism.bodies.len() as f64 * duration;
        let nothing = Mechanism::new(&mechanism.name, mechanism.gravity, Vec::new()).map_err(Failure::run)?;
        let idle = Box::new(uncalibrated(&nothing, choice)?.description());
        let (islands, accuracies) = Islands::new(plan, state, Threads::WherePaid, expected, make)?;
        let accuracy = choice
            .tolerance()
            .and_then(|tolerance| AccuracyReport::together(tolerance, state.time + duration, &accuracies));
        Ok((Engine::Islands { islands, idle }, accuracy))
    }

    /// Runs as [`run_simulation`] does.
    pub fn run(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
    ) -> (Summary, Result<(), RunError>) {
        match self {
            Engine::Whole(lobatto) => run_simulation(mechanism, state, lobatto.as_mut(), options, observers),
            Engine::Islands { islands, .. } => islands.run(mechanism, state, options, observers),
        }
    }

    /// How steps are made, and how they have gone so far.
    pub fn description(&self) -> MethodDescription {
        match self {
            Engine::Whole(lobatto) => lobatto.description(),
            Engine::Islands { islands, idle } => islands.description().unwrap_or_else(|| (**idle).clone()),
        }
    }

    /// What each island, or several that were run together, did; nothing if there is only one.
    pub fn islands(&self) -> Vec<IslandReport> {
        let all: Vec<IslandReport> = match self {
            Engine::Whole(_) => Vec::new(),
            Engine::Islands { islands, .. } => islands.figures().map(|figures| IslandReport::new(&figures)).collect(),
        };
        if all.len() > 1 { all } else { Vec::new() }
    }
}

/// The one place where an integrator is chosen; a tolerance is calibrated for the motion at hand.
fn integrator(
    mechanism: &Mechanism,
    state: &State,
    duration: f64,
    choice: StepChoice,
    kept: &[Rule],
    interrupted: &AtomicBool,
) -> Result<(Lobatto, Option<AccuracyReport>), Failure> {
    let Some(tolerance) = choice.tolerance() else { return Ok((uncalibrated(mechanism, choice)?, None)) };
    match calibrate(mechanism, state, duration, tolerance, kept, &mut |_| !interrupted.load(Ordering::Relaxed)) {
        Ok(found) => {
            let lobatto = found.integrator(mechanism, tolerance);
            Ok((lobatto, Some(AccuracyReport::new(tolerance, state.time + duration, &found))))
        }
        Err(CalibrationError::Interrupted) => Err(Failure::interrupted(CalibrationError::Interrupted)),
        // The run will fail where the pilot did, and leave its log up to there.
        Err(CalibrationError::Step(_)) => Ok((uncalibrated(mechanism, choice)?, None)),
    }
}

/// The integrator without pilot runs.
fn uncalibrated(mechanism: &Mechanism, choice: StepChoice) -> Result<Lobatto, Failure> {
    match choice {
        StepChoice::Fixed { stages, step } => Lobatto::fixed(mechanism, stages, step).map_err(Failure::input),
        StepChoice::Reversible { stages, step } => Lobatto::reversible(mechanism, stages, step).map_err(Failure::input),
        StepChoice::Precise { stages, step } => Lobatto::precise(mechanism, stages, step).map_err(Failure::input),
        StepChoice::Tolerance(tolerance) => Ok(Lobatto::adaptive(mechanism, tolerance)),
    }
}

//! How the steps of a run are chosen.

use crate::events::Eventful;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::stepping::integrator::{Lobatto, MethodError};
use crate::stepping::length::stage_choice::StageChoice;
use crate::stepping::recipe::Steps;

/// How steps are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepChoice {
    /// Stages and steps from the wanted accuracy of positions (m).
    Tolerance(f64),
    /// The same, with the control of each step's own error alone: the run makes no estimate of its error at the end, for about half the time.
    Unestimated(f64),
    /// Stages and step as given, with steps of so many seconds. One stage steps over events, of first order at impacts.
    Fixed {
        /// Number of stages: [`StepChoice::OVER_EVENTS`], or 2 to 16 of the Lobatto scheme.
        stages: usize,
        /// Length of the steps (s).
        step: f64,
    },
    /// Steps follow the pace of the motion, from a first step on, so that very long runs do not drift.
    Reversible {
        /// Number of stages.
        stages: usize,
        /// Length of the first step (s).
        step: f64,
    },
    /// As given, solved to 32 digits.
    Precise {
        /// Number of stages.
        stages: usize,
        /// Length of the steps (s).
        step: f64,
    },
}

impl StepChoice {
    /// The number of stages of steps over events: the Lobatto scheme begins with two.
    pub const OVER_EVENTS: usize = Eventful::STAGES_OVER_EVENTS;

    /// The same for a run of this duration (s), in which no fixed step is longer.
    #[must_use]
    pub fn within(self, duration: f64) -> Self {
        match self {
            StepChoice::Fixed { stages, step } => StepChoice::Fixed { stages, step: step.min(duration) },
            StepChoice::Precise { stages, step } => StepChoice::Precise { stages, step: step.min(duration) },
            // The step of reversible steps is a measure of those that are made.
            StepChoice::Tolerance(_) | StepChoice::Unestimated(_) | StepChoice::Reversible { .. } => self,
        }
    }

    /// The same without an estimate of the error, where a tolerance chooses the steps.
    #[must_use]
    pub fn without_estimate(self) -> Self {
        match self {
            StepChoice::Tolerance(tolerance) => StepChoice::Unestimated(tolerance),
            other => other,
        }
    }

    /// The same with a step that is longer by a factor, where one was given.
    #[must_use]
    pub fn with_steps_times(self, factor: f64) -> Self {
        match self {
            StepChoice::Fixed { stages, step } => StepChoice::Fixed { stages, step: factor * step },
            StepChoice::Reversible { stages, step } => StepChoice::Reversible { stages, step: factor * step },
            StepChoice::Precise { stages, step } => StepChoice::Precise { stages, step: factor * step },
            StepChoice::Tolerance(_) | StepChoice::Unestimated(_) => self,
        }
    }

    /// The wanted accuracy, where steps are chosen from it (m).
    pub fn tolerance(self) -> Option<f64> {
        match self {
            StepChoice::Tolerance(tolerance) | StepChoice::Unestimated(tolerance) => Some(tolerance),
            StepChoice::Fixed { .. } | StepChoice::Reversible { .. } | StepChoice::Precise { .. } => None,
        }
    }

    /// The step that was given (s).
    pub fn step(self) -> Option<f64> {
        match self {
            StepChoice::Tolerance(_) | StepChoice::Unestimated(_) => None,
            StepChoice::Fixed { step, .. } | StepChoice::Reversible { step, .. } | StepChoice::Precise { step, .. } => {
                Some(step)
            }
        }
    }

    /// The integrator alone, without an estimate of its error; `kept` are the rules that are switched off.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn integrator(self, mechanism: &Mechanism, kept: &[Rule]) -> Result<RunIntegrator, MethodError> {
        let smooth = mechanism.nonsmooth.is_empty();
        let alone = |lobatto: Lobatto| Ok(RunIntegrator::from(lobatto.keeping(mechanism, kept)));
        match self {
            StepChoice::Fixed { stages, step } => RunIntegrator::new(mechanism, Steps::Fixed { stages, step }, kept),
            StepChoice::Reversible { .. } if !smooth => Err(MethodError::NotReversible),
            StepChoice::Precise { .. } if !smooth => Err(MethodError::NotPlain),
            StepChoice::Reversible { stages, step } => alone(Lobatto::reversible(mechanism, stages, step)?),
            StepChoice::Precise { stages, step } => alone(Lobatto::precise(mechanism, stages, step)?),
            StepChoice::Tolerance(tolerance) | StepChoice::Unestimated(tolerance) => {
                let stages = StageChoice::of(mechanism, tolerance);
                RunIntegrator::new(mechanism, Steps::Chosen { tolerance, stop: 1e-4 * tolerance, stages }, kept)
            }
        }
    }
}

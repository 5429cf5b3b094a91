//! The settings of a run that estimates its own error: the tolerance, and how its steps may be chosen.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::simulation::method::held::Held;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::forecast::FINEST;
use crate::stepping::integrator::MethodError;
use crate::stepping::length::control::COARSEST_STOP;
use crate::stepping::length::stage_choice::StageChoice;
use crate::stepping::recipe::{Recipe, Steps};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The wanted accuracy of a run, and its settings.
#[derive(Clone)]
pub struct Terms<'a> {
    /// The accuracy (m).
    pub tolerance: f64,
    /// When the run begins and ends (s).
    pub start: f64,
    pub end: f64,
    /// Simplification rules that are switched off.
    pub kept: Vec<Rule>,
    /// The rank counts of the closures at the start.
    pub counted: Option<Arc<Counted>>,
    /// A flag that ends the run when it is set.
    pub interrupt: Option<Held<'a, AtomicBool>>,
    /// Whether the run estimates its error.
    pub estimate: bool,
    /// The part of the accuracy that steps over events are made for: less than 1 if the run has begun again because of them.
    pub over_events: f64,
}

/// The wanted accuracy over the first stop of a smooth run,
const OPTIMISTIC: f64 = 100.0;
/// and of a run with events, because a late restart costs more.
const CAREFUL: f64 = 1000.0;

/// The stop of a run with this tolerance (m) at its first beginning.
pub(crate) fn first_stop(mechanism: &Mechanism, tolerance: f64) -> f64 {
    let part = if mechanism.nonsmooth.is_empty() { OPTIMISTIC } else { CAREFUL };
    (tolerance / part).clamp(FINEST, COARSEST_STOP)
}

impl Terms<'_> {
    /// The stop that a run begins with.
    pub(crate) fn first_stop(&self, mechanism: &Mechanism) -> f64 {
        first_stop(mechanism, self.tolerance)
    }

    /// Whether the flag is set.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupt.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// The integrator with this iteration stop and these stages.
    ///
    /// # Errors
    /// [`MethodError`] for steps that cannot be.
    pub(crate) fn run(
        &self,
        mechanism: &Mechanism,
        stop: f64,
        stages: StageChoice,
    ) -> Result<RunIntegrator, MethodError> {
        self.run_bounded(mechanism, stop, stages, 1.0)
    }

    /// The same with another stop in steps that given instants end early: `bounded` times the stop of others.
    ///
    /// # Errors
    /// [`MethodError`] for steps that cannot be.
    pub(crate) fn run_bounded(
        &self,
        mechanism: &Mechanism,
        stop: f64,
        stages: StageChoice,
        bounded: f64,
    ) -> Result<RunIntegrator, MethodError> {
        let steps = Steps::Chosen { tolerance: self.tolerance * self.over_events, stop, stages };
        let recipe = Recipe { bounded, ..Recipe::new(steps, self.kept.clone()) };
        let mut run = RunIntegrator::of(mechanism, recipe)?.counted(self.counted.clone());
        if self.estimate {
            run.keep_estimate();
        }
        run.heed_interrupt(self.interrupt.as_ref());
        // The height that accumulating impacts leave is an error, as the increments at the stop are.
        Ok(run.leaving(stop / self.first_stop(mechanism), 1.0))
    }
}

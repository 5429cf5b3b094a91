//! The recipe of an integrator: for the mechanism of a run, and for the reduced mechanism while some joints are held.

use crate::integrator::{Lobatto, MethodError};
use crate::length::stage_choice::StageChoice;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;

/// Settings that all [`Lobatto`]s of one run share.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// How their steps are chosen.
    pub steps: Steps,
    /// Disabled simplification rules.
    pub kept: Vec<Rule>,
    /// Whether a program asks for every step: all of them end at instants that it gives.
    pub asked_for: bool,
    /// The stop of steps that given instants end early, over the stop of others.
    pub bounded: f64,
}

/// How steps are chosen.
#[derive(Clone, Copy, Debug)]
pub enum Steps {
    /// As given.
    Fixed {
        /// Number of stages.
        stages: usize,
        /// Length of the steps (s).
        step: f64,
    },
    /// Chosen for an iteration stop, with this number of stages.
    Chosen {
        /// The tolerance of the run (m).
        tolerance: f64,
        /// The increment at which the iteration stops [m or rad].
        stop: f64,
        /// The number of stages.
        stages: StageChoice,
    },
}

impl Recipe {
    /// A recipe for steps that a run makes for itself.
    pub fn new(steps: Steps, kept: Vec<Rule>) -> Self {
        Recipe { steps, kept, asked_for: false, bounded: 1.0 }
    }

    /// The integrator for a mechanism.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn lobatto(&self, mechanism: &Mechanism) -> Result<Lobatto, MethodError> {
        let lobatto = match self.steps {
            Steps::Fixed { stages, step } => Lobatto::fixed(mechanism, stages, step)?,
            Steps::Chosen { tolerance, stop, stages } => {
                Lobatto::adaptive_with_stages(mechanism, tolerance, stop, stages).ending_at_instants_with(self.bounded)
            }
        };
        Ok(lobatto.keeping(mechanism, &self.kept))
    }
}

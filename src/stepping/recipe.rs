//! How an integrator is made: for the mechanism of a run, and for what moves of it while some joints are held.

use crate::integrator::{Lobatto, MethodError};
use crate::length::stage_choice::StageChoice;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;

/// What [`Lobatto`]s of one run have in common.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// How their steps are chosen.
    pub steps: Steps,
    /// Rules that leave nothing out.
    pub kept: Vec<Rule>,
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
    /// From an iteration stop, with so many stages.
    Chosen {
        /// The tolerance of the run (m).
        tolerance: f64,
        /// Where the iteration stops [m or rad].
        stop: f64,
        /// The number of stages.
        stages: StageChoice,
    },
}

impl Recipe {
    /// The integrator for a mechanism.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn lobatto(&self, mechanism: &Mechanism) -> Result<Lobatto, MethodError> {
        let lobatto = match self.steps {
            Steps::Fixed { stages, step } => Lobatto::fixed(mechanism, stages, step)?,
            Steps::Chosen { tolerance, stop, stages } => {
                Lobatto::adaptive_with_stages(mechanism, tolerance, stop, stages)
            }
        };
        Ok(lobatto.keeping(mechanism, &self.kept))
    }
}

//! The accuracy of a run, or why it is not known.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Nonsmooth;
use crate::stepping::length::stage_choice::StageChoice;

/// Why the accuracy of a run is not known.
#[derive(Clone, Debug, thiserror::Error)]
pub enum UnknownAccuracy {
    /// Stages and steps were given.
    #[error("no --tolerance was asked for")]
    NotAsked,
    /// The run has made no step yet.
    #[error("the run ended before its error could be estimated")]
    NotYet,
    /// External efforts act, which the companion of the error estimate does not have.
    #[error("a program sets efforts on the joints, and the error estimate does not know its law")]
    Driven,
    /// The run was asked for no estimate.
    #[error("the run makes no estimate (--no-estimate); each step keeps to its share of the tolerance")]
    NotEstimated,
    /// A program makes the steps of the run.
    #[error(
        "a program makes this run step by step: each step keeps to its share of the tolerance, and the error at the end is not estimated"
    )]
    Stepped,
}

/// The accuracy of a run, as the run itself estimates it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// The iteration stop of its steps.
    pub stop: f64,
    /// Their number of stages.
    pub stages: StageChoice,
    /// The estimated error at the end of the worst step (m).
    pub estimate: f64,
    /// The error of samples inside the steps, beside the error of their ends (m); `None` if it is not known.
    pub between_steps: Option<f64>,
    /// The last instant up to which the estimated error meets the tolerance (s); the end of the run if it always does.
    pub holds_until: f64,
    /// The instant up to which this is known (s): the end of the run, or a little before if it was interrupted.
    pub told_until: f64,
    /// Whether the run and the one beside it have parted before the end, so that finer steps would not help.
    pub parted: bool,
    /// Whether its errors may grow from almost zero, as errors of chaotic motions do ([`may_be_chaotic`]).
    pub amplifies: bool,
    /// If the accuracy does not hold to the end: the first instant (s) from which the run and the one beside it meet different events (impacts,
    /// sticking, bounds of motors).
    pub events_differ: Option<f64>,
    /// How many times the run was begun.
    pub begun: usize,
}

/// Whether a motion can amplify errors for ever. A single freedom cannot, without impacts, dry friction and targets that change in time.
pub(crate) fn may_be_chaotic(mechanism: &Mechanism) -> bool {
    let Nonsmooth { limits, friction, motors, pairs, .. } = &mechanism.nonsmooth;
    let is_struck = !limits.is_empty() || !friction.is_empty() || !pairs.is_empty();
    mechanism.velocity_count > 1 || is_struck || motors.iter().any(|motor| !motor.target.is_constant())
}

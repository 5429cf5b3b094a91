//! The owned parts of the integrator with events: a constant model, workspaces, the step at hand, the progress of the run, its tally, and the last step.

pub(super) mod model;
pub(super) mod previous;
pub(super) mod progress;
pub(super) mod tally;
pub(super) mod trial;
pub(super) mod workspaces;

//! The owned parts of the integrator with events: a constant model, workspaces, the step at hand, the progress of the run, its tally, the last step, and
//! the trace of its steps and jumps.

pub(super) mod jams;
pub(super) mod model;
pub(super) mod previous;
pub(super) mod progress;
pub(super) mod repeats;
pub(super) mod spells;
pub(super) mod spending;
pub(super) mod tally;
pub(super) mod traced;
pub(super) mod trial;
pub(super) mod workspaces;

//! The integrator of a run, the scheme alone or with events, and how its steps are chosen.

pub mod run_integrator;
pub(crate) mod step_choice;

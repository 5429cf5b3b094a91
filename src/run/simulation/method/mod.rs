//! The integrator of a run, the scheme alone or with events, and how its steps are chosen.

pub mod held;
pub(crate) mod narrowed_inputs;
pub mod run_integrator;
pub mod run_steps;
pub(crate) mod step_choice;
pub(crate) mod without_locked;

//! The loop: step, sample, observe, until the end of the run.
//!
//! An [`Integrator`] advances the state and can be asked for any instant of its last step; [`Observer`]s see samples at
//! a fixed rate (the log) and the end of every step (energy, constraint and solver figures). The loop is the same for
//! the Lobatto scheme and for the reduced-coordinate comparators, so that charts compare like with like.

pub mod accuracy;
mod course;
mod integrators;
pub mod island;
pub mod islands;
pub mod merged;
mod observer;
#[expect(clippy::module_inception, reason = "the run is the one object of this floor")]
mod simulation;
mod step_choice;
mod summary;
pub mod threads;
pub mod trial_run;

pub(crate) use course::Course;
pub use course::{RunError, RunOptions, run};
pub use integrators::SimulationError;
pub(crate) use observer::show;
pub use observer::{Counts, Observer, ObserverError, Sample, StepEnd};
pub use simulation::{Finished, InputError, Simulation, SimulationOptions};
pub use step_choice::StepChoice;
pub use summary::Summary;

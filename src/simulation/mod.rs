//! A run: [`Simulation`] holds the mechanism, its state, external efforts, the integrators of its islands, the error estimate, and the observers.
//!
//! An [`Integrator`](crate::mechanism::motion::integrator::Integrator) makes steps and interpolates within its last one. [`Observer`]s receive
//! samples at a fixed rate (the log) and the end of every step (energy, constraint and solver figures). The Lobatto scheme and the
//! reduced-coordinate comparators share the loop (`run`), so that charts compare like with like.
//!
//! | what | where |
//! |---|---|
//! | the run as an object | `run`, `integrators`, `making`, `run_integrator`, `step_choice` |
//! | controllers, which set efforts | `controller`, `continuous` |
//! | one mechanism, step by step | `course`, `summary`, `observer` |
//! | islands in parallel | `partition`, `islands`, `island`, `merged`, `threads` |
//! | error estimates for a tolerance | `assessed`, `beside`, `terms`, `forecast`, `accuracy_so_far` (during runs), `accuracy`, `trial_run` (before), `event_order` |

#[doc(hidden)]
pub mod accuracy;
mod accuracy_so_far;
#[doc(hidden)]
pub mod assessed;
mod beside;
mod clock;
mod continuous;
mod controller;
mod course;
mod event_order;
mod forecast;
mod integrators;
mod island;
#[doc(hidden)]
pub mod islands;
#[doc(hidden)]
pub mod making;
mod merged;
mod observer;
#[doc(hidden)]
pub mod partition;
mod run;
#[doc(hidden)]
pub mod run_integrator;
mod step_choice;
mod summary;
pub(crate) mod terms;
#[doc(hidden)]
pub mod threads;
mod trial_run;

pub use accuracy::UnknownAccuracy;
pub use accuracy_so_far::AccuracySoFar;
pub use continuous::ContinuousController;
pub use controller::{ControlError, Controller};
pub(crate) use course::Course;
pub use course::{RunError, RunOptions, run};
pub use integrators::SimulationError;
pub(crate) use observer::show;
pub use observer::{Counts, Observer, ObserverError, Sample, StepEnd};
pub use run::{Finished, InputError, Simulation, SimulationOptions};
pub use step_choice::StepChoice;
pub use summary::Summary;
pub use trial_run::CalibrationError;

//! A run: [`Simulation`] holds the mechanism, its state, what acts on it from outside, the integrators of its islands, the accuracy to expect,
//! and who watches.
//!
//! An [`Integrator`](crate::mechanism::motion::integrator::Integrator) makes steps and can be asked for any instant of its last one; [`Observer`]s
//! see samples at a fixed rate (the log) and the end of every step (energy, constraint and solver figures). The loop under it ([`run`]) is the
//! same for the Lobatto scheme and for the reduced-coordinate comparators, so that charts compare like with like.
//!
//! | what | where |
//! |---|---|
//! | the run as an object | `run`, `integrators`, `making`, `run_integrator`, `step_choice` |
//! | who decides on efforts | `controller`, `continuous` |
//! | one mechanism, step by step | `course`, `summary`, `observer` |
//! | independent parts side by side | `partition`, `islands`, `island`, `merged`, `threads` |
//! | the accuracy that a tolerance means | `assessed`, `beside`, `terms`, `forecast` (the run tells it as it goes along), `accuracy`, `trial_run` (trial runs do before), `event_order` |

#[doc(hidden)]
pub mod accuracy;
#[doc(hidden)]
pub mod assessed;
mod beside;
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

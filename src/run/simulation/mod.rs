//! A run: [`Simulation`] holds the mechanism, its state, external efforts, the integrators of its islands, the error estimate, and the observers.
//!
//! An [`Integrator`](crate::mechanism::motion::integrator::Integrator) makes steps and interpolates within its last one. [`Observer`]s receive
//! samples at a fixed rate (the log) and the end of every step (energy, constraint and solver figures). The Lobatto scheme and the
//! reduced-coordinate comparators share the loop (`run`), so that charts compare like with like.
//!
//! | what | where |
//! |---|---|
//! | the run as an object | `run`, `integrators`; what it tells: `finished` |
//! | copies of a run, from which it goes on | `checkpoint` |
//! | a start that a run has begun from before | `known_start` |
//! | efforts and targets that a program sets | `acting` |
//! | controllers, which set efforts | `controller`, `continuous` |
//! | the integrator, and how steps are chosen | `method` |
//! | the error of a run, estimated while it goes on | `tolerance` |
//! | one mechanism, step by step | `steps` |
//! | islands in parallel | `parallel` |

mod acting;
mod checkpoint;
mod continuous;
mod controller;
mod finished;
mod input_error;
mod integrators;
mod known_start;
#[doc(hidden)]
pub mod method;
#[doc(hidden)]
pub mod parallel;
mod run;
#[doc(hidden)]
pub mod steps;
#[doc(hidden)]
pub mod tolerance;

pub use checkpoint::Checkpoint;
pub use continuous::ContinuousController;
pub use controller::{ControlError, Controller};
pub use finished::Finished;
pub use input_error::InputError;
pub use integrators::SimulationError;
pub use method::step_choice::StepChoice;
pub use run::{Simulation, SimulationOptions};
pub use steps::course::{RunError, RunOptions, run};
pub use steps::observer::{Counts, Observer, ObserverError, Sample, StepEnd};
pub use steps::summary::Summary;
pub use tolerance::accuracy::{Accuracy, UnknownAccuracy};
pub use tolerance::accuracy_so_far::AccuracySoFar;

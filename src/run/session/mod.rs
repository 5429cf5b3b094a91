//! A run with all its options: a file, a start, an accuracy, a log, a report. The command line, Rust programs and Python all make their runs here,
//! so that results cannot differ.
//!
//! ```text
//!     file ─ world.rs ─▶ Loaded ─ loaded.rs ─▶ state on its loops ─┐
//!     options ─ asked.rs ─▶ Settled ───────────────────────────────┴▶ simulation::Simulation
//!     running.rs: opens a run with its log and observers, and closes it      account.rs: what is said of it in log and report
//!     description.rs: how it was made
//! ```

mod account;
mod asked;
mod batch;
mod between_ticks;
mod control;
mod coordinates;
mod description;
mod dynamics;
mod error;
mod held_start;
mod linear;
mod linear_slopes;
mod loaded;
mod many;
mod model;
mod other_steps;
mod place;
mod quantities;
mod recording;
mod rollout;
mod running;
mod sensors;
mod simulation;
mod special_output;
mod state;
mod tangents;
mod ticks;
mod urdf_text;
mod watch;
mod words;
mod world;

// What is chosen for models and runs.
pub use crate::mechanism::description::rules::Rule;
pub use crate::model::Left;
#[cfg(feature = "log")]
pub use crate::output::log::{LogOptions, Meshes, Topics};
pub use crate::scene::Touching;
#[doc(hidden)]
pub use account::Told;
#[doc(hidden)]
pub use asked::{Asked, Settled};
pub use batch::Batch;
pub use control::Moment;
pub use coordinates::{Coordinates, JointPlace};
#[doc(hidden)]
pub use description::{DRIVEN, HELD, Origin};
pub use error::{ControllerFailure, Error};
#[cfg(feature = "scene")]
pub use held_start::mechanism_from;
pub use held_start::{HeldTargets, Hold};
pub use linear::{Linear, Mode, Stability, discrete};
pub use linear_slopes::EigenvalueSlopes;
#[doc(hidden)]
pub use loaded::{Assembled, Loaded};
pub use many::{Rollout, Trajectories};
pub use model::{Loader, Model};
#[cfg(feature = "log")]
#[doc(hidden)]
pub use place::check_log;
#[doc(hidden)]
pub use place::{check_place, folder_of};
pub use recording::{Recording, SharedRecording};
#[doc(hidden)]
pub use running::{Course, Finish, Running};
pub use sensors::{Noise, Sensed};
pub use simulation::{
    Backward, EventLost, EventSlope, Gradient, JointValue, Lost, Multipliers, SampledEvent, Samples, Sensitivity,
    Simulation,
};
pub use state::State;
#[doc(hidden)]
pub use world::World;

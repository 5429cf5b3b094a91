//! A run as people ask for it: a file, a start, an accuracy, a log, a report. The command line, programs and Python make runs here alone, so that
//! they cannot differ.
//!
//! ```text
//!     file ─ world.rs ─▶ Loaded ─ loaded.rs ─▶ state on its loops ─┐
//!     options ─ asked.rs ─▶ Settled ───────────────────────────────┴▶ simulation::Simulation
//!     account.rs: what is said of it in log and report      description.rs: how it was made
//! ```

mod account;
mod asked;
mod description;
mod error;
mod loaded;
mod place;
mod world;

pub use account::{Account, Begun, Ended};
pub use asked::{Asked, Settled};
pub use description::{DRIVEN, Origin};
pub use error::{ControllerFailure, Error};
pub use loaded::{Assembled, Loaded};
pub use place::{check_log, check_place, folder_of};
pub use world::{World, is_scene};

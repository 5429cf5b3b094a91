//! The names that most programs need.

pub use crate::mechanism::description::joint::Pose;
pub use crate::mechanism::motion::energy::Energy;
pub use crate::model::{Left, LinkState};
#[cfg(feature = "urdf-rs")]
pub use crate::of_urdf_rs::{FromUrdfRs, LoadUrdfRs};
pub use crate::output::report::Report;
pub use crate::session::{Error, Loader, Model, Moment, Simulation};
pub use crate::simulation::Observer;

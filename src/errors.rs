//! The causes that an [`Error`] may hold.

pub use crate::derivatives::forward::failure::SensitivityError;
pub use crate::derivatives::linear::about::LinearizeError;
pub use crate::instant::start::assembly::AssemblyError;
pub use crate::mechanism::description::mechanism::MechanismError;
pub use crate::mechanism::motion::step_error::StepError;
pub use crate::model::{CouplingError, CouplingProblem, ModelError};
pub use crate::output::log::LogError;
pub use crate::scene::{Element, Problem, SceneError};
pub use crate::session::{ControllerFailure, Error};
pub use crate::simulation::{InputError, RunError, SimulationError};
pub use crate::stepping::integrator::MethodError;

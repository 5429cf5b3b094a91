//! The names that most programs need.

pub use crate::mechanism::description::joint::{Joint, JointKind, Pose};
pub use crate::mechanism::description::mechanism::{Body, Mechanism};
pub use crate::mechanism::motion::state::State;
pub use crate::model::{Model, ModelOptions};
pub use crate::scene::{PackagePath, read_scene, read_urdf};
pub use crate::simulation::{Observer, Simulation, SimulationOptions, StepChoice};

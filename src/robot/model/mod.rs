//! The parts that must be simulated: joints, bodies, the mechanism they form, and the place of the robot of the URDF in it.
//!
//! | what | where |
//! |---|---|
//! | the nouns: records, frames, coordinates, errors, pairs of shapes | `description` |
//! | from links to bodies | `reduction` |
//! | loops, mimic relations, forces, limits, motors, shapes | `coupling` |
//! | where the robots are at the start | `assemble` |

mod assemble;
mod coupling;
mod description;
mod reduction;

pub use assemble::Start;
pub use description::at_start::AtStart;
pub use description::contact_pairs::{ContactRecord, LeftOutPair, Owner, RopeRecord};
pub use description::coordinates::{JointCoordinates, position_names, velocity_names};
pub use description::coupling_error::{CouplingError, CouplingProblem};
pub use description::model_error::ModelError;
pub use description::never_touch::NeverTouch;
pub use description::robot_model::{
    JointRecord, LinkFrame, LinkState, Model, PlacedRobot, Reduction, ReductionRule, SourceFile,
};
pub use description::wheel::Wheel;
pub use description::without::{Left, UnknownLeft};
pub use reduction::reduce::{Base, ModelOptions};

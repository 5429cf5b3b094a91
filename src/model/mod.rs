//! What must be simulated: joints, bodies, the mechanism they form, and where the robot of the URDF is in it.

mod closure;
mod composite;
mod coordinates;
mod definiteness;
pub mod joint;
mod joint_frame;
mod mechanism;
mod model_error;
mod reduce;
mod rigid_groups;
mod robot_model;

pub use closure::{Attachment, Coordinate, LoopJoint, LoopKind, Mimic};
pub use composite::Composite;
pub use coordinates::{position_names, velocity_names};
pub use joint::{FreeRotation, Joint, JointKind, Pose, wxyz_from_rotation};
pub use mechanism::{Body, Mechanism, MechanismError};
pub use model_error::ModelError;
pub use reduce::{Base, ModelOptions};
pub use robot_model::{JointRecord, LinkFrame, LinkState, Model, Reduction, ReductionRule};

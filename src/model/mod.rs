//! What must be simulated: joints, bodies, the mechanism they form, and where the robot of the URDF is in it.

mod assemble;
mod composite;
mod constant_followers;
mod contact;
mod contact_meshes;
mod contact_pairs;
mod contact_reach;
mod coordinates;
mod coupling_builder;
mod coupling_error;
mod coupling_forces;
mod coupling_joints;
mod coupling_limits;
mod coupling_loops;
mod coupling_motors;
mod couplings;
mod joint_frame;
mod model_error;
mod reduce;
mod reported;
mod rigid_groups;
mod robot_model;
mod start_checks;
mod tied_joints;
mod without;

pub use assemble::Start;
pub use composite::Composite;
pub use contact_pairs::{ContactRecord, LeftOutPair, NeverTouch, Owner};
pub use coordinates::{JointCoordinates, position_names, velocity_names};
pub use coupling_error::{CouplingError, CouplingProblem};
pub use model_error::ModelError;
pub(crate) use model_error::listed;
pub use reduce::{Base, ModelOptions};
pub use robot_model::{JointRecord, LinkFrame, LinkState, Model, PlacedRobot, Reduction, ReductionRule, SourceFile};
pub use without::{Left, UnknownLeft};

//! What must be simulated: joints, bodies, the mechanism they form, and where the robot of the URDF is in it.

mod assemble;
mod closure;
mod composite;
mod coordinates;
mod coupling_error;
mod coupling_forces;
mod coupling_joints;
mod coupling_loops;
mod couplings;
mod definiteness;
mod islands;
pub mod joint;
mod joint_frame;
mod lean;
mod mechanism;
mod model_error;
mod plane;
mod reduce;
mod reported;
mod rigid_groups;
mod robot_model;
mod rules;

pub use assemble::Start;
pub use closure::{Attachment, Coordinate, JointLimit, LoopJoint, LoopKind, Mimic};
pub use composite::Composite;
pub use coordinates::{JointCoordinates, position_names, velocity_names};
pub use coupling_error::{CouplingError, CouplingProblem};
pub use islands::{Island, Piece, islands};
pub use joint::{FreeRotation, Joint, JointKind, Pose, sine_cosine, wxyz_from_rotation};
pub use lean::{point_bodies, sliding_bodies};
pub use mechanism::{Body, Mechanism, MechanismError};
pub use model_error::ModelError;
pub use plane::Plane;
pub use reduce::{Base, ModelOptions};
pub use robot_model::{JointRecord, LinkFrame, LinkState, Model, PlacedRobot, Reduction, ReductionRule, SourceFile};
pub use rules::{Rule, UnknownRule};

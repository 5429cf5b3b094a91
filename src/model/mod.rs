//! What must be simulated: joints, bodies, and the mechanism they form.

pub mod joint;
mod mechanism;

pub use joint::{FreeRotation, Joint, JointKind, Pose};
pub use mechanism::{Body, Mechanism, MechanismError};

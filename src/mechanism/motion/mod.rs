//! The state, and what follows from it at one instant: poses, gaps of the closures and contacts, energy and momentum, distances; and what an integrator is.

pub mod contact_geometry;
pub mod contact_point;
pub mod distance;
pub mod efforts;
pub mod energy;
pub mod event;
pub mod gaps;
pub mod inputs;
pub mod integrator;
pub mod joint_coordinates;
pub mod kinematics;
pub mod state;
pub mod step_error;
pub mod touches;

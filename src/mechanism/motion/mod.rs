//! The state, and what follows from it at one instant: poses, gaps of the closures, energy and momentum, distances; and what an integrator is.

pub mod distance;
pub mod energy;
pub mod event;
pub mod gaps;
pub mod inputs;
pub mod integrator;
pub mod kinematics;
pub mod state;

//! The state, and its functions at one instant: poses, gaps of closures and contacts, energy and momentum, distances; and the interface of
//! integrators.

pub mod contact_geometry;
pub mod contact_point;
pub mod contact_solvers;
pub mod cost;
pub mod distance;
pub mod efforts;
pub mod energy;
pub mod event;
pub mod gaps;
pub mod inputs;
pub mod integrator;
pub mod joint_accelerations;
pub mod joint_coordinates;
pub mod kinematics;
pub mod level_rims;
pub(crate) mod moving_points;
pub mod reeved;
pub mod rim_and_line;
pub mod state;
pub mod step_error;
pub mod touches;

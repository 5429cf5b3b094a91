//! Accelerations under efforts and velocities after impulses, with closures and followers.

pub(crate) mod closing;
pub(crate) mod dampings;
pub(crate) mod following;
pub mod mass_matrix;
pub mod response;
pub(crate) mod response_on_tree;

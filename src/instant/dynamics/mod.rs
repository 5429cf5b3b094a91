//! Accelerations under efforts and velocities after impulses, with closures and followers.

pub(crate) mod closing;
pub(crate) mod following;
pub(crate) mod mass_matrix;
pub(crate) mod response;
pub(crate) mod response_on_tree;

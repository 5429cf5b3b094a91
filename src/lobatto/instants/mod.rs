//! Poses of links and wrenches of joints at eight instants of a motion at once, one instant per lane. Logs use them.
//!
//! [`snapshot`] defines the input and the result. [`tree`] is the recursion over the bodies, [`constants`] and [`joints`] are its data,
//! [`quaternion`] its rotations.

pub mod constants;
pub mod joints;
pub mod quaternion;
pub mod snapshot;
pub mod tree;

//! Where links are and what joints carry at eight instants of a motion at once: one instant a lane. For logs.
//!
//! [`snapshot`] says what is asked for; [`tree`] is the recursion over the bodies, [`constants`] and [`joints`] are what it reads, [`quaternion`] is its
//! rotations.

pub mod constants;
pub mod joints;
pub mod quaternion;
pub mod snapshot;
pub mod tree;

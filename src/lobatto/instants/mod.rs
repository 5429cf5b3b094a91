//! Where links are and what joints carry at eight instants of a motion at once.

pub mod constants;
pub mod instants;
pub mod joints;
pub mod quaternion;
pub mod tree;

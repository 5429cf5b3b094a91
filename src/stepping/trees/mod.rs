//! On another spanning tree than the file's: states and efforts on their way in and out.

pub(crate) mod driven_elsewhere;
pub mod other_tree;
pub(crate) mod turns;

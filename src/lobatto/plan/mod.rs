//! What can be known of a mechanism before the first step: the order of the sweeps, of the forces and of the elimination.

pub mod elimination;
pub mod forces;
pub mod planner;
pub mod tree;

//! Derivatives of a run by its start and its numbers, through its own steps.

pub(crate) mod between;
pub(in crate::derivatives) mod elimination;
pub mod failure;
pub(in crate::derivatives) mod figure_slopes;
mod first_stages;
mod spatial;
pub mod stage_equations;
pub mod step;
pub mod tangent;
mod touching;
pub mod tree;
mod tree_factors;
pub mod twelve;

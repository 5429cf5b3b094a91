//! The problem of a step over many impacts: impulses of all contacts, limits, friction and motors of an island of trees, and its solvers.
//!
//! - [`trees`], [`tree`]: mass matrices in joint rates, and `closures`: which of them follow others;
//! - [`rows`]: the rows of contacts and joints on the trees, and [`islands`]: trees that they join;
//! - [`laws`], [`problem`]: the equations;
//! - `elimination`, `block_factors`, [`newton`], `centred`, `interior` (with [`jordan`]), `convex`, [`solver`]: the solvers and their order, and `stall`, which ends them.

#![deny(unsafe_code)]

mod block_factors;
mod centred;
mod closures;
mod convex;
mod effort;
mod elimination;
mod interior;
pub mod islands;
pub mod jordan;
pub mod laws;
pub mod newton;
pub mod problem;
pub mod rows;
pub mod solver;
mod stall;
pub mod tree;
pub mod trees;

//! How many equations of the closures are independent at a configuration, by kinematics alone.
//!
//! [`rows`] computes their gradients without dimension. [`counting`] counts the independent ones, by [`row_pivoting`] and in large mechanisms by
//! [`insertion`]. [`lending`] finds the inertia that is lent to light freedoms where closures connect them to heavy ones.

pub mod counting;
pub mod insertion;
pub mod lending;
pub mod row_pivoting;
pub mod rows;

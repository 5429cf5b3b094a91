//! How many equations of the closures are independent at a configuration, by kinematics alone.
//!
//! [`rows`] writes their gradients without dimension; [`counting`] counts those that are independent, by [`row_pivoting`] and in large mechanisms by
//! [`insertion`]; [`lending`] finds the inertia that light freedoms are lent where closures tie them to heavy ones.

pub mod counting;
pub mod insertion;
pub mod lending;
pub mod row_pivoting;
pub mod rows;

//! Which function of a mode changes its sign within a step, and where.

pub(crate) mod approach;
pub mod cover;
pub(crate) mod cycle;
pub(crate) mod detection;
mod dips;
pub(crate) mod extremes;
pub(crate) mod reserves;
pub(crate) mod speeds;
pub(crate) mod travel;
pub(crate) mod watched;

//! Which function of a mode changes its sign within a step, and where.

pub(crate) mod approach;
pub(crate) mod cycle;
pub(crate) mod detection;
pub(crate) mod watched;

//! The coefficients of the scheme, its limit of stability, and dense output: all that depends on the number of stages alone.

pub mod butcher;
pub mod dense;
pub mod exact;
pub mod stability;

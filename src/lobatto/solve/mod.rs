//! The simplified Newton step over the tree, and the iteration that repeats it.

pub mod anderson;
pub mod free_body;
pub mod iteration;
pub mod kept_factors;
pub mod single_precision;
pub mod sweeps;

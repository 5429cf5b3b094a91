//! The exact Newton step, with all stages and all closures coupled; the projections on the closures that are made with it.

pub mod closing;
pub mod front;
pub mod multipliers;
pub mod newton;
pub mod operations;
pub mod projection;
pub mod repeated_solve;
pub mod space;
pub mod system;

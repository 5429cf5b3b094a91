//! The stage equations: residuals of bodies, loops and forces at all stages.

pub mod forces;
pub mod loops;
pub mod pivot;
pub mod residual;

//! The stage equations: residuals of bodies, loops and forces at all stages.

pub mod forces;
pub mod loops;
pub mod pivot;
pub mod residual;
pub mod spatial_loops;
pub(crate) mod springs;

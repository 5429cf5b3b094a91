//! The equations of motion of a mechanism, over numbers that carry derivatives.

pub mod closed;
pub mod closures;
pub mod contacts;
pub mod figures;
pub mod laws;
pub mod placed;
pub mod residual;

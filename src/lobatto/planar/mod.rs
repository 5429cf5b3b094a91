//! The same equations for mechanisms that move in a plane: three coordinates a body instead of six.

pub mod algebra;
pub mod articulated;
pub mod body;
pub mod force_plan;
pub mod forces;
pub mod geometry;
pub mod kept_factors;
pub mod loops;
pub mod start;
pub mod sweeps;
pub mod workspace;

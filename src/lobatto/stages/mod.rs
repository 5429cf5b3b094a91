//! The start of a step, the poses and the rows of all stages, the first guess: the workspace.

pub mod articulated;
pub mod attempt;
pub mod coefficients;
pub mod extrapolation;
pub mod factors;
pub mod force_motion;
pub mod forces;
pub mod momenta;
pub mod pose;
pub mod predictor;
pub mod predictor_balls;
pub mod row_geometry;
pub mod rows;
pub mod start;
pub mod unknowns;
pub mod workspace;

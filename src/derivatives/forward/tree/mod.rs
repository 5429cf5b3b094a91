//! Steps of trees: the equations of [`crate::derivatives::forward::stage_equations`] and their derivatives written out, without numbers with derivatives.
//!
//! | file | contents |
//! |---|---|
//! | `spatial` | motions of bodies and forces on them |
//! | `family` | which freedoms move which bodies |
//! | `step` | the equations |
//! | `matrix` | their derivatives by the unknowns, and the factors |
//! | `column` | their derivatives by all that is given |
//! | `adjoint` | the transpose of that, for gradients |
//! | `solve` | steps solved, and derivatives carried over them |

mod adjoint;
#[cfg(test)]
mod against_duals;
mod column;
mod family;
mod matrix;
mod solve;
mod spatial;
mod step;

pub(in crate::derivatives) use adjoint::FigureCotangents;
pub(in crate::derivatives) use column::FigureSlopes;
pub(in crate::derivatives::forward) use matrix::TreeFactors;
pub(in crate::derivatives) use solve::pulled_back;
pub(in crate::derivatives::forward) use solve::{TreeColumns, solve_tree};
pub(in crate::derivatives::forward) use step::is_tree;

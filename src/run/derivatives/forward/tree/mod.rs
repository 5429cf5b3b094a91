//! Steps of trees: the equations of [`crate::derivatives::forward::stage_equations`] and their derivatives written out, without numbers with
//! derivatives.
//!
//! | file | contents |
//! |---|---|
//! | `family` | which freedoms move which bodies |
//! | `step` | the equations |
//! | `matrix` | their derivatives by the unknowns, and the factors |
//! | `looped` | the same with closures |
//! | `course` | motions of freedoms and frames along a step |
//! | `displaced` | displacements of all bodies by such motions |
//! | `column` | their derivatives by all that is given |
//! | `adjoint` | the transpose of that, for gradients |
//! | `solve` | steps solved |
//! | `momenta` | momenta of velocities at one place, and how they vary: for impacts |
//! | `carrying` | derivatives carried over them: columns, rows, and against time |
//! | `over_step` | the choice between these equations and the equations of all mechanisms |

mod adjoint;
#[cfg(test)]
mod against_duals;
mod carrying;
mod column;
mod course;
mod displaced;
mod family;
mod looped;
mod matrix;
mod momenta;
mod over_step;
mod solve;
mod step;

pub(in crate::derivatives) use adjoint::FigureCotangents;
pub(in crate::derivatives) use carrying::pulled_back;
pub(in crate::derivatives) use momenta::Momenta;
pub(in crate::derivatives) use over_step::by_length;

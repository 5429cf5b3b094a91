//! Crowds: steps over many impacts at once, each with all contacts, limits, friction and motors of the scene.
//!
//! | file | contents |
//! |---|---|
//! | `contacts` | candidates: what may press, hold or pull in a step, and the rows of it |
//! | `moving`, `settling`, `lifting`, `energies` | the parts of a step |
//! | `step` | the step |
//!
//! Trees, rows, the problem of an island and its solvers are in [`crate::crowd`].

pub(crate) mod contacts;
mod energies;
mod lifting;
mod moving;
mod settling;
pub(crate) mod step;

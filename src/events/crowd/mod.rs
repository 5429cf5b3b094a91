//! Crowds: steps over many impacts at once, each with all contacts, limits, friction and motors of the scene.
//!
//! | file | contents |
//! |---|---|
//! | `trees` | mass matrices of the trees in joint rates |
//! | `contacts` | candidates: what may press, hold or pull in a step, and the rows of it |
//! | `islands` | groups of trees that touch |
//! | `laws`, `problem`, `block_factors`, `newton`, `convex` | the problem of an island, and its solvers |
//! | `moving`, `settling`, `lifting`, `energies` | the parts of a step |
//! | `step` | the step |

mod block_factors;
pub(crate) mod contacts;
mod convex;
mod energies;
mod islands;
mod laws;
mod lifting;
mod moving;
mod newton;
mod problem;
mod settling;
pub(crate) mod step;
#[cfg(test)]
mod tests;
mod trees;

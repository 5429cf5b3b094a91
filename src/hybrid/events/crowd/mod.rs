//! Crowds: steps over many impacts at once, each with all contacts, limits, friction and motors of the scene.
//!
//! | file | contents |
//! |---|---|
//! | `contacts` | candidates: what may press, hold or pull in a step, and the rows of it |
//! | `clearances`, `speeds` | how far pairs are apart, and how fast they may come near |
//! | `free`, `moving`, `rebounding`, `settling`, `lifting`, `energies` | the parts of a step |
//! | `asleep`, `resting`, `sleeping` | trees that sleep, how they fall asleep and wake, and crowds with them |
//! | `step`, `inside` | the step, and states inside it |
//!
//! Trees, rows, the problem of an island and its solvers are in [`crate::crowd`].

mod asleep;
mod clearances;
pub(crate) mod contacts;
mod energies;
mod free;
mod inside;
mod lifting;
mod moving;
mod rebounding;
mod resting;
mod settling;
mod sleeping;
mod speeds;
pub(crate) mod step;

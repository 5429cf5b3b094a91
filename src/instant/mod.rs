//! Problems at one instant: the assembly of closed loops, the reactions of joints and loops, and whether the mechanism is in equilibrium.
//!
//! | where | what is in it |
//! |---|---|
//! | `dynamics` | accelerations under efforts, velocities after impulses |
//! | `holding` | what can hold or press, as elements and as rows of one problem |
//! | `cone` | the laws of that problem and their solvers |
//! | `start` | closed loops, limits kept, shapes moved apart |
//! | `exerting` | reactions, rest, snapshots for logs |

pub(crate) mod cone;
pub(crate) mod dynamics;
pub mod exerting;
pub mod holding;
pub mod start;

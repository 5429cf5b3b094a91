//! Problems at one instant: the assembly of closed loops, the reactions of joints and loops, and whether the mechanism is in equilibrium.
//!
//! | room | contents |
//! |---|---|
//! | `dynamics` | accelerations under efforts, velocities after impulses |
//! | `holding` | elements that can hold or press, and the rows of one problem for them |
//! | `cone` | the laws of that problem and their solvers |
//! | `start` | closed loops, limits kept, shapes moved apart |
//! | `exerting` | reactions, rest, snapshots for logs |
//! | `meeting`, `moved` | parts that may meet soon, and parts that have not met; how far bodies move |

pub mod cone;
pub mod dynamics;
pub mod exerting;
pub mod holding;
pub mod meeting;
pub mod moved;
pub mod start;

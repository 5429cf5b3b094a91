//! Problems at one instant: the assembly of closed loops, the reactions of joints and loops, and whether the mechanism is in equilibrium.

mod apart;
pub mod assembly;
mod assembly_elsewhere;
pub(crate) mod blocks;
mod box_programme;
mod closing;
pub(crate) mod cone;
pub(crate) mod elements;
mod exerted;
mod following;
#[doc(hidden)]
pub mod limits;
pub(crate) mod mass_matrix;
pub mod reactions;
mod reactions_elsewhere;
mod reactions_on_tree;
pub(crate) mod response;
mod response_on_tree;
pub mod rest;
#[doc(hidden)]
pub mod snapshots;
pub mod statuses;
pub(crate) mod touching;
mod unbalanced;
pub mod unreachable;

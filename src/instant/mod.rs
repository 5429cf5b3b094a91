//! The problem at one instant: how closed loops are assembled, what joints and loops carry, whether anything moves at all.

pub mod assembly;
mod box_programme;
#[doc(hidden)]
pub mod limits;
mod mass_matrix;
pub mod reactions;
pub mod rest;
#[doc(hidden)]
pub mod snapshots;
pub mod unreachable;

//! The problem at one instant: how closed loops are assembled, what joints and loops carry, whether anything moves at all.

pub mod assembly;
#[doc(hidden)]
pub mod limits;
pub mod reactions;
pub mod rest;
#[doc(hidden)]
pub mod snapshots;

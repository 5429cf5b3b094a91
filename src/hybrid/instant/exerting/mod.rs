//! The forces that joints and contacts exert in a state: reactions, rest, snapshots for logs.

pub mod exerted;
pub mod reactions;
pub(crate) mod reactions_elsewhere;
pub(crate) mod reactions_on_tree;
pub mod rest;
#[doc(hidden)]
pub mod snapshots;
pub(crate) mod unbalanced;

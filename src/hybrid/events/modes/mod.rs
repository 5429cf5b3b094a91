//! The states of joints, motors and contacts between two events, and the reduced mechanism that moves in them.

pub(crate) mod drives;
pub(crate) mod inside_bodies;
pub(crate) mod instants;
pub(crate) mod loose;
pub(crate) mod mode;
pub(crate) mod narrowed;
pub(crate) mod piece;
pub(crate) mod piece_recipe;
pub(crate) mod placed;
pub(crate) mod present;
pub(crate) mod tolerances;

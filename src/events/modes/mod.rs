//! What joints, motors and contacts do between two events, and what is left to move while they do it.

pub(crate) mod drives;
pub(crate) mod instants;
pub(crate) mod mode;
pub(crate) mod narrowed;
pub(crate) mod piece;
pub(crate) mod piece_steps;
pub(crate) mod present;

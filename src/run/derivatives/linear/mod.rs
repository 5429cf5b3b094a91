//! Linear equations of motion about a state, in independent joint coordinates, and their modes.

pub mod about;
pub(crate) mod elsewhere;
pub mod equations;
pub mod equilibrium;
pub mod independent;
pub mod linearised;
pub mod modes;

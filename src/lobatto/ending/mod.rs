//! The end of a step: its momenta, and the joint velocities that carry them (2.5.11h).

pub mod free_body;
pub mod refinement;
pub mod velocities;

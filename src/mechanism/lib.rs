//! What is simulated: rigid bodies, joints, closures and forces; and their state, kinematics and energy at one instant.
//!
//! | room | what is in it |
//! |---|---|
//! | [`description`] | the mechanism: constant |
//! | [`forces`] | the physics of each force |
//! | [`motion`] | the state: what changes in time, and what follows from it at one instant |
//! | [`structure`] | what can be known before anything moves: planes, islands, special bodies, independent closures |
//! | [`ground`] | small matrices, numbers in sentences |

#![deny(unsafe_code)]

pub mod description;
pub mod forces;
#[doc(hidden)]
pub mod ground;
pub mod motion;
pub mod structure;

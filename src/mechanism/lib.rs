//! Mechanisms: rigid bodies, joints, closures and forces; and their state, kinematics and energy at one instant.
//!
//! | module | what is in it |
//! |---|---|
//! | [`description`] | the mechanism: constant |
//! | [`forces`] | the equations of each force |
//! | [`motion`] | the state, which changes in time, and its functions at one instant |
//! | [`structure`] | properties that do not depend on the motion: planes, islands, special bodies, independent closures |
//! | [`ground`] | small matrices, formatting of numbers |

#![deny(unsafe_code)]

pub mod description;
pub mod forces;
#[doc(hidden)]
pub mod ground;
pub mod motion;
pub mod structure;

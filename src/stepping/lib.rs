//! The integrator: the length of each step, its acceptance, and monitoring during a run.
//!
//! | what | where |
//! |---|---|
//! | the integrator, and how those of one run are made | [`integrator`], [`recipe`] |
//! | the length of a step: given, chosen, accepted or made again; how many stages | [`length`] |
//! | monitoring every few steps | [`watching`] |
//! | instants inside a step: samples, their error, what a controller sees | [`instants`] |
//! | on another spanning tree than the file's | [`trees`] |
//! | the one interface of everything that makes steps | [`step_maker`] |

#![deny(unsafe_code)]

#[doc(hidden)]
pub mod instants;
#[doc(hidden)]
pub mod integrator;
pub mod length;
#[doc(hidden)]
pub mod recipe;
/// Steps between given instants.
pub mod spans;
pub mod step_maker;
pub mod trees;
#[doc(hidden)]
pub mod watching;

pub use integrator::{Lobatto, MethodError};

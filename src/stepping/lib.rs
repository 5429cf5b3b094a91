//! The integrator: the length of each step, its acceptance, and monitoring during a run.
//!
//! | what | where |
//! |---|---|
//! | the integrator | [`integrator`], [`stepper`] |
//! | the length of a step | [`fixed`], [`control`] and [`acceptance`], [`reversible`]; how many stages: [`stage_choice`] |
//! | monitoring every few steps | [`watch`], [`modes`], [`fastest_mode`], [`dynamics`], [`jerks`], [`linearised`] |
//! | instants inside a step | [`sampling`], `inside` (which polynomial, and its error), `levers`, `stage_motion` |
//! | on another spanning tree than the file's | [`other_tree`], `driven_elsewhere`, `turns` |
//! | efforts of a controller that follow the state | `feedback` |

#![deny(unsafe_code)]

#[doc(hidden)]
pub mod acceptance;
#[doc(hidden)]
pub mod companion;
pub mod control;
mod driven_elsewhere;
#[doc(hidden)]
pub mod dynamics;
#[doc(hidden)]
pub mod fastest_mode;
mod feedback;
#[doc(hidden)]
pub mod fixed;
mod inside;
#[doc(hidden)]
pub mod integrator;
#[doc(hidden)]
pub mod jerks;
mod levers;
#[doc(hidden)]
pub mod linearised;
#[doc(hidden)]
pub mod modes;
pub mod other_tree;
#[doc(hidden)]
pub mod pace;
#[doc(hidden)]
pub mod recipe;
#[doc(hidden)]
pub mod reversible;
#[doc(hidden)]
pub mod sampling;
#[doc(hidden)]
pub mod stage_choice;
mod stage_motion;
#[doc(hidden)]
pub mod stepper;
mod turns;
#[doc(hidden)]
pub mod unseen;
#[doc(hidden)]
pub mod watch;

pub use integrator::{Lobatto, MethodError};

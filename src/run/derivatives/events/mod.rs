//! Derivatives through events: steps that end where a watched function is zero, and jumps of velocities at one instant.

mod bearing;
mod closing;
mod directions;
pub mod efforts;
mod impact;
mod impulse_factors;
pub mod instant;
mod jumping;
mod limit_impact;
mod locating;
mod looks;
mod meet;
mod near;
pub mod parameter;
pub(crate) mod reverse;
mod sharing;
mod solving;
mod starting;
mod struck;
mod ticks;
mod together;
pub mod validity;
pub mod walk;
pub mod watched;

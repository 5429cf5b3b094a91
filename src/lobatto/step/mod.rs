//! One step of the scheme as a whole.
//!
//! ```text
//!     begin(state) → attempt(h) → finish: velocities at the end → accept: the end is the next start
//! ```
//!
//! [`interface`] is the interface for the integrator. [`kernel`] and [`kernel_step`] make the step, over a [`workspace`] in space ([`spatial`]) or
//! in a plane ([`planar`]). [`carrying`] integrates a second motion with the same factorisation; [`carried`] is that motion. [`precise`] and
//! [`precise_start`] solve the step to 32 digits; [`make`] chooses the vectors.

pub(crate) mod carried;
pub(crate) mod carrying;
pub mod interface;
pub(crate) mod kernel;
mod kernel_step;
pub mod make;
mod planar;
pub mod precise;
pub mod precise_start;
pub(crate) mod spatial;
mod workspace;

//! One step of the scheme as a whole.
//!
//! ```text
//!     begin(state) → attempt(h) → finish: velocities at the end → accept: the end is the next start
//! ```
//!
//! [`interface`] is what those see who string steps together. [`kernel`] and [`kernel_step`] make it, over a [`workspace`] in space ([`spatial`]) or in a plane
//! ([`planar`]); [`carrying`] moves a second motion through it, which is [`carried`]; [`precise`] and [`precise_start`] solve it to 32 digits; [`make`] hands the vectors out.

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

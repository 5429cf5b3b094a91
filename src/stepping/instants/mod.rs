//! Instants inside a step: its polynomial, the error of samples, and a controller's view of the stages.

pub(crate) mod feedback;
pub(crate) mod inside;
pub(crate) mod levers;
#[doc(hidden)]
pub mod sampling;
pub(crate) mod stage_motion;

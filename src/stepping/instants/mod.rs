//! Instants inside a step: which polynomial, its error, and what a controller sees at the stages.

pub(crate) mod feedback;
pub(crate) mod inside;
pub(crate) mod levers;
#[doc(hidden)]
pub mod sampling;
pub(crate) mod stage_motion;

//! Starts: loops are closed, limits kept, shapes moved apart, or it is told why that cannot be.

pub(crate) mod apart;
pub mod assembly;
pub(crate) mod assembly_elsewhere;
pub mod damped_points;
pub mod gimbal_lock;
#[doc(hidden)]
pub mod limits;
pub mod long_periods;
pub mod unreachable;
pub(crate) mod wedged;

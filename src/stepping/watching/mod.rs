//! Quantities monitored every few steps: the linearised motion, its fastest mode, jerks, and the work of forces over roundings.

#[doc(hidden)]
pub mod dynamics;
#[doc(hidden)]
pub mod fastest_mode;
#[doc(hidden)]
pub mod jerks;
#[doc(hidden)]
pub mod linearised;
#[doc(hidden)]
pub mod modes;
#[doc(hidden)]
pub mod pace;
pub(crate) mod ranks;
pub(crate) mod standstills;
#[doc(hidden)]
pub mod unseen;
#[doc(hidden)]
pub mod watch;

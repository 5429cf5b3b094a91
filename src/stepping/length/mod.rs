//! The length of a step: given or chosen, accepted or made again; the companion with another length beside it.

#[doc(hidden)]
pub mod acceptance;
pub(crate) mod beside_dampers;
#[doc(hidden)]
pub mod companion;
pub mod control;
#[doc(hidden)]
pub mod energies;
#[doc(hidden)]
pub mod fixed;
pub(crate) mod outside;
#[doc(hidden)]
pub mod reversible;
pub(crate) mod span;
#[doc(hidden)]
pub mod stage_choice;
#[doc(hidden)]
pub mod stepper;
pub(crate) mod stride;

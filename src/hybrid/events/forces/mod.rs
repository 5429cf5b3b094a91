//! The forces that hold joints and press on closed contacts at an instant.

pub(crate) mod chosen;
pub(crate) mod closed_forces;
pub(crate) mod foreseen;
pub(crate) mod holding;
pub(crate) mod reporting;
pub(crate) mod returning;

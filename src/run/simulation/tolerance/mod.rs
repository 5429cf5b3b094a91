//! The error of a run, estimated while it goes on.

pub mod accuracy;
pub(crate) mod accuracy_so_far;
pub(crate) mod beside;
pub mod error_estimate;
pub mod estimated_run;
pub(crate) mod event_order;
pub(crate) mod forecast;
pub(crate) mod given_forces;
pub(crate) mod handed;
pub(crate) mod horizon;
pub mod terms;

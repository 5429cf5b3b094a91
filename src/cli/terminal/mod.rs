//! What a person at the terminal sees, and how runs are interrupted.

pub(crate) mod printing;
pub(crate) mod progress;
pub(crate) mod signals;
pub(crate) mod special_output;

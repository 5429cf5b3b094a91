//! Arguments that several verbs have, and how their values are read.

pub(crate) mod contact_args;
pub(crate) mod input;
pub(crate) mod log_options;
pub(crate) mod numbers;
pub(crate) mod outputs;

//! Inputs of any format: which one it is, and its reader.

pub(crate) mod input;

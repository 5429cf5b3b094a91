//! The base of all other folders: small matrices, numbers with derivatives, formatting of numbers and nouns, and values that are shared.

pub mod guarded;
pub mod matrices;
pub mod shared;
pub mod smooth;
pub mod words;

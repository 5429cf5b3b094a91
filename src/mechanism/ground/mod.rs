//! The base of all other folders: small matrices, numbers with derivatives, and formatting of numbers and nouns.

pub mod matrices;
pub mod smooth;
pub mod words;

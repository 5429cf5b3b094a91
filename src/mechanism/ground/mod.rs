//! The base of all other folders: small matrices, disjoint sets, numbers with derivatives, formatting of numbers and nouns, and values that are shared.

pub mod disjoint_sets;
pub mod guarded;
pub mod matrices;
pub mod shared;
pub mod smooth;
pub mod words;

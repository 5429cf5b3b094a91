//! What everything stands on: small matrices, numbers with derivatives, and numbers and nouns in sentences.

pub mod matrices;
pub mod smooth;
pub mod words;

//! What everything stands on: small matrices, and numbers and nouns in sentences.

pub mod matrices;
pub mod words;

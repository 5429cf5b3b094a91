//! The scheme word for word: the oracle of the tests.

pub mod constraints;
pub mod coordinates;
pub mod forces;
pub mod newton;
pub mod scheme;

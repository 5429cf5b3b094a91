//! The method: the constrained Lobatto IIIA–IIIB scheme (2.5.11).

mod extended;
pub mod literal;
pub mod tableau;

//! Numbers that carry derivatives, and their vectors.

pub mod dual;
pub mod jet;
pub mod number;
pub mod vector;

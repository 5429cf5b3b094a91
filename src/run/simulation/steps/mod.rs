//! One mechanism, step by step: the interface of observers, and the sums over steps.

pub(crate) mod clock;
pub(crate) mod course;
pub(crate) mod observer;
pub(crate) mod summary;
pub(crate) mod undefined;
pub(crate) mod way;

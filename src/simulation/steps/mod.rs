//! One mechanism, step by step: what observers see, and what is summed up.

pub(crate) mod clock;
pub(crate) mod course;
pub mod making;
pub(crate) mod observer;
pub(crate) mod summary;

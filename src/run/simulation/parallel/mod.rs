//! Islands in parallel: which bodies belong together, their threads, and their figures merged.

pub(crate) mod between;
pub(crate) mod groups;
pub(crate) mod island;
pub mod islands;
pub(crate) mod merged;
pub mod partition;
pub(crate) mod regrouping;
pub mod threads;

//! Elements that can hold or press: limits, friction, motors and contacts, also as rows of one problem.

pub mod blocks;
pub mod elements;
pub mod held;
pub(crate) mod kept_by_loops;
pub mod locked;
pub(crate) mod moments;
pub(crate) mod near;
pub(crate) mod pairs;
pub(crate) mod per_pair;
pub(crate) mod revolving;
pub(crate) mod rolling;
pub(crate) mod rope;
pub(crate) mod sparse;
pub mod statuses;
pub mod touching;
pub(crate) mod weights;

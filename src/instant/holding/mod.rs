//! Elements that can hold or press: limits, friction, motors and contacts, also as rows of one problem.

pub(crate) mod blocks;
pub(crate) mod elements;
pub(crate) mod held;
pub mod locked;
pub(crate) mod moments;
pub(crate) mod near;
pub(crate) mod pairs;
pub(crate) mod per_pair;
pub(crate) mod rope;
pub(crate) mod sparse;
pub mod statuses;
pub(crate) mod touching;

//! Tables of `catena model`.

pub(crate) mod contact_tables;
pub(crate) mod couplings;
pub(crate) mod joint_tables;
pub(crate) mod rules;
pub(crate) mod table;

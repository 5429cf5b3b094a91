//! The topics of a log, a file for each kind of message, and which of them a log has.

pub(crate) mod collision_shapes;
pub(crate) mod contact_forces;
pub(crate) mod contacts;
pub(crate) mod description;
pub(crate) mod events;
pub(crate) mod figures;
pub(crate) mod joints;
pub(crate) mod motors;
pub(crate) mod options;
pub(crate) mod pair_names;
pub(crate) mod ropes;
pub(crate) mod sensitivities;
pub(crate) mod standin;
pub(crate) mod topics;
pub(crate) mod transforms;
pub(crate) mod visual;

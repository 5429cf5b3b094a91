//! The parts of a mechanism besides the tree: loops, mimic relations, forces, limits, friction, motors, shapes.

pub(crate) mod builder;
pub(crate) mod contact;
pub(crate) mod contact_meshes;
pub(crate) mod couplings;
pub(crate) mod forces;
pub(crate) mod gravity;
pub(crate) mod joints;
pub(crate) mod limits;
pub(crate) mod loops;
pub(crate) mod motions;
pub(crate) mod motors;
pub(crate) mod overlaps;
pub(crate) mod relations;
pub(crate) mod ropes;
pub(crate) mod rotors;

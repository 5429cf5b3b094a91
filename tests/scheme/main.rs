//! The scheme, its solver and its steps: what the method claims.

#[path = "../closed/mod.rs"]
mod closed;
#[path = "../common/mod.rs"]
mod common;
#[path = "../in_plane/mod.rs"]
mod in_plane;
#[path = "../models/mod.rs"]
mod models;

mod chord;
mod first_iterations;
mod forces;
mod invariants;
mod literal_equality;
mod literal_scheme;
mod loops;
mod order;
mod planar;
mod precise;
mod reversible;
mod snapshots;
mod stability;
mod stages;
mod stepping;
mod symplectic;

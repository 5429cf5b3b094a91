//! The scheme, its solver and its steps: what the method claims.

// `models` names its mechanisms by this path, so that tests of single crates have it, too.
use catena::mechanism;

#[path = "../shared/closed/mod.rs"]
mod closed;
#[path = "../shared/common/mod.rs"]
mod common;
#[path = "../shared/in_plane/mod.rs"]
mod in_plane;
#[path = "../shared/linkage/mod.rs"]
mod linkage;
#[path = "../shared/models/mod.rs"]
mod models;
#[path = "../shared/runge_kutta/mod.rs"]
mod runge_kutta;

mod both_ends;
mod chord;
mod companion;
mod first_iterations;
mod forces;
mod inputs;
mod invariants;
mod literal;
mod literal_equality;
mod literal_scheme;
mod loops;
mod order;
mod planar;
mod precise;
mod ranks;
mod refinement;
mod reversible;
mod snapshots;
mod spanning_tree;
mod special_bodies;
mod stability;
mod stages;
mod stepping;
mod symplectic;
mod touches;

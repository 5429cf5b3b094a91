//! What does not allocate on the heap, counted by an allocator that other tests do without.

// `models` names its mechanisms by this path, so that tests of single crates have it, too.
use catena::mechanism;

#[path = "../shared/closed/mod.rs"]
mod closed;
#[path = "../shared/linkage/mod.rs"]
mod linkage;
#[path = "../shared/models/mod.rs"]
mod models;

mod sample;
mod step;

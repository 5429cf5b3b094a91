//! What does not allocate on the heap, counted by an allocator that other tests do without.

// The models are those of programs with the crates of the method alone, too.
use catena::mechanism;

#[path = "../shared/closed/mod.rs"]
mod closed;
#[path = "../shared/linkage/mod.rs"]
mod linkage;
#[path = "../shared/models/mod.rs"]
mod models;

mod sample;
mod step;

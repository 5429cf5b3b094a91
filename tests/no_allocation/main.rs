//! What does not allocate on the heap, counted by an allocator that other tests do without.

#[path = "../shared/closed/mod.rs"]
mod closed;
#[path = "../shared/linkage/mod.rs"]
mod linkage;
#[path = "../shared/models/mod.rs"]
mod models;

mod sample;
mod step;

//! What does not allocate on the heap, counted by an allocator that other tests do without.

#[path = "../closed/mod.rs"]
mod closed;
#[path = "../models/mod.rs"]
mod models;

mod sample;
mod step;

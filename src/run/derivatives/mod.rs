//! Derivatives of motions: equations of motion over numbers that carry their own derivatives, and results computed with them.
//!
//! | room | contents |
//! |---|---|
//! | `numbers` | numbers with derivatives: by parameters ([`numbers::dual`]) and by time ([`numbers::jet`]) |
//! | `equations` | places, forces and closures of a mechanism, written once for any such number |
//! | `forward` | derivatives of a run by its start and its numbers, through its own steps |
//! | `events` | the same through events: a step ends where a function is zero, and velocities jump |
//! | `linear` | equilibria, linear equations of motion, and their modes |
//!
//! A room imports those above it in this table. Only runs with derivatives call this code.

pub mod equations;
pub mod events;
pub mod forward;
pub mod linear;
pub mod numbers;

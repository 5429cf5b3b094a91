//! The solver of contact problems at one instant: limits, joint friction and contacts with Coulomb's law, all together.
//!
//! ```text
//!     u = D r + b        D (m × m) symmetric, positive semidefinite
//! ```
//!
//! `problem.rs` defines the problem, `scaled.rs` makes it dimensionless. `laws.rs` has the equations of the laws and `newton.rs` solves them. The
//! first guess comes from `sweeps.rs` (with `single.rs`, one contact), `interior.rs` or, last, `oracle.rs`
//! (clarabel). `cascade.rs` has their order and `settling.rs` the resulting states. Based on these: `least_compliance.rs` (which forces are
//! reported), `margin.rs` (whether all contacts can stay closed), `sharing.rs` (impulses on redundant contacts) and `impact.rs` (restitution). `apart.rs` splits what falls apart.

pub(crate) mod apart;
pub(crate) mod bounded;
mod cascade;
pub mod impact;
mod interior;
mod laws;
mod least_compliance;
pub(crate) mod least_norm;
mod margin;
mod newton;
mod oracle;
pub mod problem;
mod scaled;
#[cfg(test)]
pub(crate) mod scenes;
mod settling;
pub(crate) mod sharing;
mod single;
mod sweeps;
#[cfg(test)]
mod trials;

pub(crate) use cascade::{solve, solve_apart, solve_roughly};
pub(crate) use least_compliance::least_compliance;
#[cfg(test)]
pub(crate) use margin::margin;
pub(crate) use margin::{Known, margin_or_clear};

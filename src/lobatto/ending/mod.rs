//! The end of a step: its momenta, and the joint velocities that carry them.
//!
//! ```text
//!     p̄ = p₀ + h Σ_k b_k F_k,     H(q̄) v̄ = Sᵀ p̄          (2.5.11h)
//! ```
//!
//! [`velocities`] solves it in one lane, [`two_motions`] for a run and its companion in two, [`refinement`] recovers digits beside gimbal locks,
//! [`free_body`] has the special case of one free body.

pub mod free_body;
pub mod refinement;
pub(crate) mod two_motions;
pub mod velocities;

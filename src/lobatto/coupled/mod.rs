//! The exact Newton step, which couples all stages and all closures, and the projections that use the same matrix.
//!
//! ```text
//!     Σ_i D_ki η_i − J_kᵀ dλ_k = −(E_k − J_kᵀ λ_k)          bodies, projected on the joint axes at the rows' stages
//!     J_i η_i + ε Σ_k Â_ik dλ_k = −g_i                      closures; ε acts on increments alone
//! ```
//!
//! [`mod@system`] defines the symbols. [`front`] and [`operations`] eliminate in the order of [`crate::plan::elimination`], contacts with the world
//! at their bodies ([`given`]). [`dependent`] first removes rounding from the gaps of contacts that imply each other. [`space`] is the geometry in
//! space, with the contacts of [`touching`] ([`crate::planar::geometry`] is the geometry in a plane). [`newton`] iterates. [`projection`] and
//! [`closing`] project states and velocities onto the closures. Once, at the start of a run, [`deciding`] classifies the closures from the ranks
//! [`counted`]: which [`equations`] are empty or redundant, which freedoms cannot move ([`known`]), and which inertia is [`lent`] to light freedoms.

pub mod closing;
pub mod counted;
pub mod deciding;
pub mod dependent;
pub mod equations;
pub mod front;
pub mod given;
pub(crate) mod groups;
pub mod known;
pub mod lent;
pub mod mixing;
pub mod multipliers;
pub mod newton;
pub mod operations;
pub mod projection;
pub mod repeated_solve;
pub mod space;
pub mod system;
pub mod touching;

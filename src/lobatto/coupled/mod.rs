//! The exact Newton step, with all stages and all closures coupled, and the projections that are made with it.
//!
//! ```text
//!     Σ_i D_ki η_i − J_kᵀ dλ_k = −(E_k − J_kᵀ λ_k)          bodies, projected on the joint axes at the rows' stages
//!     J_i η_i + ε Σ_k Â_ik dλ_k = −g_i                      closures; ε acts on increments alone
//! ```
//!
//! [`mod@system`] has the symbols; [`front`] and [`operations`] eliminate after the order of [`crate::plan::elimination`]; [`space`] is the geometry in space
//! ([`crate::planar::geometry`] that in a plane), with the contacts of [`touching`]; [`newton`] iterates; [`projection`] and [`closing`] bring states and velocities onto the closures.
//! Once, at the start of a run, [`deciding`] decides from what was [`counted`] what is [`known`] of them: which [`equations`] are empty or implied, which freedoms are still, and
//! what light ones are [`lent`].

pub mod closing;
pub mod counted;
pub mod deciding;
pub mod equations;
pub mod front;
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

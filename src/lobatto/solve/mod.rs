//! The simplified Newton step over the tree, and the iteration that repeats it.
//!
//! ```text
//!     δ_i = Σ_k Â_ik α_k,   H(q_k) α_k = −ρ_k         one sweep from the leaves to the root, one back      [`sweeps`]
//!     θ ← Anderson(θ, δ)                              until |δ| is small enough                           [`anderson`], [`iteration`]
//! ```
//!
//! [`kept_factors`] reuses the factorisation of an earlier iteration, [`single_precision`] does the first iterations with seven digits, [`free_body`]
//! has the step of a body that floats freely.

pub mod anderson;
pub mod free_body;
pub mod iteration;
pub mod kept_factors;
pub mod single_precision;
pub mod sweeps;

//! The coefficients of the scheme, which depend on the number of stages s alone. Equation numbers: see the documentation of the crate.
//!
//! ```text
//!     c_i, b_j                nodes and weights of Lobatto's quadrature, c₁ = 0, c_s = 1
//!     a_ij, ā_ij              Lobatto IIIA and its partner IIIB, b_i ā_ij + b_j a_ji = b_i b_j         (2.5.11)
//!     B_ki, Â = B⁻¹           (2.5.11) solved for the forces: M Σ_i B_ki (Q_i − q₀ − h c_i q̇₀) = h² F_k,   i = 2 … s, k = 1 … s − 1
//! ```
//!
//! [`butcher`] has them as doubles with the rounded-off parts, [`mod@exact`] computes them to 32 digits, [`stability`] bounds `h ω`, [`dense`]
//! interpolates between the ends of a step, and [`dampers`] shares dampers among the rows of the simplified Newton step.

pub mod butcher;
pub(crate) mod dampers;
pub mod dense;
pub mod exact;
pub mod stability;

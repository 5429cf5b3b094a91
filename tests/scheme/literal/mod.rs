//! The scheme as published, with twelve coordinates per body: the reference of the tests. It shares no code with the fast scheme except the
//! tableau.
//!
//! ```text
//!     Q_i = q₀ + h Σ_j a_ij M⁻¹ P_j,   P_i = p₀ + h Σ_j ā_ij (F(Q_j) − Dg(Q_j)ᵀ Λ_j),   g(Q_i) = 0          (2.5.11)
//! ```

pub mod constraints;
pub mod coordinates;
pub mod forces;
pub mod newton;
pub mod pairs;
pub mod scheme;
pub mod touches;

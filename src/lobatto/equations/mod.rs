//! The residuals of the stage equations, at all stages at once.
//!
//! ```text
//!     ρ_k = Sᵀ ( M Σ_i B_ki (Q_i − q₀ − h c_i q̇₀) − h² F_k )          what RᵀR = 1 and the joints leave of (2.5.11)
//!     g(Q_i) = 0                                                       loops and mimic relations, where there are any
//! ```
//!
//! [`residual`] has the bodies, [`mod@pivot`] the special case of a body on a hinge that the world holds, [`forces`] and [`springs`] the applied
//! forces, [`loops`] and [`spatial_loops`] the closures, [`touches`], [`braking`], `slips` and `turning` the contacts, `reeved` the ropes
//! through several points, `origins` the points about which twists and wrenches are taken.

pub mod braking;
pub mod forces;
pub(crate) mod friction_moments;
pub(crate) mod holding;
pub(crate) mod loads;
pub mod loops;
pub(crate) mod origins;
pub mod pivot;
pub(crate) mod reeved;
pub mod residual;
pub mod rotors;
pub(crate) mod slips;
pub mod spatial_loops;
pub(crate) mod springs;
pub mod touches;
pub(crate) mod turning;

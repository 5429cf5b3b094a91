//! The workspace of a step: its start, the poses and rows of all stages, the first guess, and the results of the sweeps.
//!
//! | symbol | what | unit | where |
//! |---|---|---|---|
//! | `θ_i` | displacements of the freedoms since the start at stage i: the unknowns | rad, m | [`workspace`], [`unknowns`] |
//! | `(w, u)`, `N` | rotation of a body since the start, `N = R R₀ᵀ − 1` | | [`pose`] |
//! | `v`, `ω`, `Σ`, `com`, `arm` | the known start of the step | m/s, rad/s, kg m², m | [`start`], [`two_starts`] |
//! | `B`, `Â` | the scheme in lanes | | [`coefficients`], [`momenta`] |
//! | rows k | where the residual of row k takes its motion from | | [`rows`], [`row_geometry`] |
//! | `H`, `α` | articulated inertias and the factors that the way back needs | kg, kg m² | [`articulated`], [`factors`] |
//! | `F_k` | forces at the stages | N, N m | [`forces`], [`force_motion`] |
//!
//! [`predictor`] guesses the next step from the last one by [`extrapolation`] and [`predictor_balls`]. [`attempt`] has the inputs and the outcome
//! of an attempt.

pub mod articulated;
pub mod attempt;
pub mod coefficients;
pub mod extrapolation;
pub mod factors;
pub mod force_motion;
pub mod forces;
pub mod momenta;
pub mod pose;
pub mod predictor;
pub mod predictor_balls;
pub mod rotors;
pub mod row_geometry;
pub mod rows;
pub mod start;
pub(crate) mod two_starts;
pub mod unknowns;
pub mod workspace;

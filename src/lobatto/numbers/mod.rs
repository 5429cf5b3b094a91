//! The number types of the equations of a step: one number for each stage.
//!
//! ```text
//!     lane j  ↔  stage j + 2 of s stages           the first stage is the known start; lanes in use: s − 1
//!     Σ_i columns[i] · v[i]                        mixing: a matrix over the stages times the numbers of all stages
//! ```
//!
//! | symbol | what | where |
//! |---|---|---|
//! | `V: Lanes` | doubles, one a stage, in registers | [`lanes`], [`reductions`], [`mixing`], [`lane_arithmetic`] |
//! | `V: Numbers`, `Arithmetic` | 16 or 32 digits; all stages, or one | [`arithmetic`], [`mod@double`], [`fused`], [`twofold`], [`extended`] |
//! | `Vector<V>`, `Matrix<V>` | three-vectors and 3×3 matrices of them | [`algebra`], [`euclidean`] |
//! | `(w, u)` | unit quaternions of rotations since the start of the step | [`rotations`], [`series`] |

pub mod algebra;
pub mod arithmetic;
pub mod double;
pub(crate) mod euclidean;
pub mod extended;
pub mod fused;
pub mod lane_arithmetic;
pub mod lanes;
pub mod mixing;
pub mod reductions;
pub mod rotations;
pub mod series;
pub(crate) mod smooth_lanes;
pub mod twofold;

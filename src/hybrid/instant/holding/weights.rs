//! Weights that motors hold: they cancel within one sum, and leave their roundings.
//!
//! ```text
//!     τ: efforts that hold weights [N m or N]       acceleration of a row w of efforts by them, at most:   Σ |Y wᵀ| |τ|
//! ```
//!
//! A motor with `gravity_compensation` pulls by a part of the weight beyond its joint ([`crate::mechanism::forces::gravity_compensation`]). Limits and contacts
//! have no force then, and their accelerations are roundings of weights.

use crate::instant::holding::blocks::{Rows, fall};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;

/// The most that the efforts that hold weights accelerate each row by, where the bodies are placed; they are not asked for where no motor holds a weight.
pub(crate) fn held_weights(whole: &Mechanism, bodies: &[BodyState], rows: &Rows) -> Vec<f64> {
    let mut efforts = vec![0.0; whole.velocity_count];
    for holding in &whole.forces.gravity_compensations {
        efforts[holding.freedom] += holding.effort(whole, bodies);
    }
    rows.columns().column_iter().map(|answer| fall(answer.as_slice(), &efforts)).collect()
}

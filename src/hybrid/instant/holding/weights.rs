//! Weights that motors hold: they cancel within one sum, and leave their roundings.
//!
//! ```text
//!     Q_g = Jᵀ m g   [N m or N]       acceleration of a row w of efforts by it, at most:   Σ |Y wᵀ| |Q_g|
//! ```
//!
//! A motor with `gravity_compensation` pulls by a part of the weight beyond its joint ([`crate::mechanism::forces::gravity_compensation`]). Limits and contacts
//! have no force then, and their accelerations are roundings of weights.

use crate::instant::holding::blocks::{Rows, fall};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::efforts::efforts_of_wrenches;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;

/// The most that all weights accelerate each row by at a state, if motors hold parts of them; zero otherwise.
pub(crate) fn without_motors(whole: &Mechanism, state: &State, rows: &Rows) -> Vec<f64> {
    let answers = rows.columns();
    if whole.forces.gravity_compensations.is_empty() {
        return vec![0.0; answers.ncols()];
    }
    let bodies = body_states(whole, state);
    let mut weights: Vec<_> = whole.bodies.iter().map(|body| (whole.gravity * body.mass, Vector3::zeros())).collect();
    let mut efforts = vec![0.0; whole.velocity_count];
    efforts_of_wrenches(whole, &bodies, &mut weights, &mut efforts);
    answers.column_iter().map(|answer| fall(answer.as_slice(), &efforts)).collect()
}

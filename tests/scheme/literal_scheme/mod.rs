//! Claims about the literal scheme (2.5.11 of `doc/method.md`), the oracle of the fast solver: it has the properties that its source proves.
//!
//! Its states are compared with benchmark answers, its order with 2s − 2 (theorem 2.5.2), its trajectories with the
//! discrete Euler–Lagrange equations (2.5.8) of the discrete Lagrangian (2.5.12), none of which it is built from.

mod steps;
mod variational;

use crate::models::{self, Model};

/// A moving start, so that no term of the equations vanishes by symmetry.
fn moving_double_pendulum() -> Model {
    let mut model = models::double_pendulum();
    model.state.velocity = vec![0.9, -1.6];
    model
}

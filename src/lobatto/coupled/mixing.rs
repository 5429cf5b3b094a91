//! The matrices of the scheme as the coupled system takes them, row by row, with the stages as lanes.
//!
//! ```text
//!     B_ki of the mass blocks,  Â_ik of the proximal terms,  (Ā B)_ki of velocities in the rows,  a_ij of integrals to a stage
//! ```
//!
//! A row k is a stage as [`row_stage`] says. A system of one stage has ones everywhere: a projection at one configuration.

use crate::numbers::lanes::{Lanes, MAX_LANES};
use crate::stages::coefficients::{moved_rows, row_stage};
use crate::tableau::butcher::Tableau;

/// The matrix entries of the scheme, as the system needs them.
#[derive(Clone)]
pub struct Mixing<V> {
    /// Number of stages coupled.
    pub active: usize,
    /// Row k of B, lanes i.
    pub mass: [V; MAX_LANES],
    /// Row i of Â, lanes k.
    pub(crate) solve: [V; MAX_LANES],
    /// Row i of A, lanes j: an integral to a stage.
    pub(crate) integral: [V; MAX_LANES],
    /// Row k of Ā B, lanes i: the velocity of the rows.
    pub(crate) velocity: [V; MAX_LANES],
    /// Zero where a row has the geometry of the start.
    pub moved: V,
}

impl<V: Lanes> Mixing<V> {
    /// For a step of the scheme.
    pub fn of_stages(tableau: &Tableau) -> Self {
        let active = tableau.stages - 1;
        let row_of_lane = |lane: usize| row_stage(lane, active);
        let mut mass = [V::zero(); MAX_LANES];
        let mut solve = [V::zero(); MAX_LANES];
        let mut velocity = [V::zero(); MAX_LANES];
        let mut integral = [V::zero(); MAX_LANES];
        for lane in 0..active {
            integral[lane] = V::from_slice(&tableau.a[(lane + 1) * tableau.stages + 1..][..active]);
            velocity[lane] = V::from_slice(&tableau.velocity[row_of_lane(lane) * active..][..active]);
            let row = row_of_lane(lane) * active;
            mass[lane] = V::from_slice(&tableau.b_matrix[row..row + active]);
            let columns: Vec<f64> = (0..active).map(|k| tableau.a_hat[lane * active + row_of_lane(k)]).collect();
            solve[lane] = V::from_slice(&columns);
        }
        Mixing { active, mass, solve, integral, velocity, moved: moved_rows(active) }
    }

    /// For a projection at one configuration.
    pub fn of_one() -> Self {
        let one = [V::splat(1.0); MAX_LANES];
        Mixing { active: 1, mass: one, solve: one, integral: one, velocity: one, moved: V::zero() }
    }
}

//! The factors of the matrix R_u of a step of a tree.
//!
//! ```text
//!     R_u = | S  0 |     S: displacements of the stages     E: of the equation of v̄     M: the mass matrix at the end
//!           | E  M |
//! ```

use crate::derivatives::forward::elimination::Elimination;
use nalgebra::{DMatrix, DVector};

/// The factors.
pub struct TreeFactors {
    stages: Elimination,
    end: DMatrix<f64>,
    masses: Elimination,
}

impl TreeFactors {
    /// The factors of S, E and M; `None` if S or M is singular.
    pub fn new(stages: &DMatrix<f64>, end: DMatrix<f64>, masses: &DMatrix<f64>) -> Option<TreeFactors> {
        Some(TreeFactors { stages: Elimination::new(stages)?, end, masses: Elimination::new(masses)? })
    }

    /// `R_u⁻ᵀ` times weights of the displacements at the end and of v̄ (n each).
    pub fn solve_transposed(&self, displacements: &DVector<f64>, velocities: &DVector<f64>) -> DVector<f64> {
        let (n, many) = self.end.shape();
        let last = DVector::from_vec(self.masses.solve_transposed(velocities.as_slice().to_vec()));
        let mut right = -self.end.tr_mul(&last);
        let mut of_end = right.rows_mut(many - n, n);
        of_end += displacements;
        let first = self.stages.solve_transposed(right.as_slice().to_vec());
        DVector::from_iterator(many + n, first.into_iter().chain(last.iter().copied()))
    }

    /// Displacements and v̄ for right-hand sides.
    pub fn solve(&self, right: &DMatrix<f64>) -> DMatrix<f64> {
        let (_, many) = self.end.shape();
        let mut found = right.clone();
        for mut column in found.column_iter_mut() {
            let stages = DVector::from_vec(self.stages.solve(&column.as_slice()[..many]));
            column.rows_mut(0, many).copy_from(&stages);
            let mut end = column.rows_mut(many, column.len() - many);
            end.gemv(-1.0, &self.end, &stages, 1.0);
            let last = DVector::from_vec(self.masses.solve(end.as_slice()));
            end.copy_from(&last);
        }
        found
    }
}

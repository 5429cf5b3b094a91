//! The factors of the matrix R_u of a step of a tree.
//!
//! ```text
//!     R_u = | S  0 |     S: displacements of the stages     E: of the equation of v̄     M: the mass matrix at the end
//!           | E  M |
//! ```

use nalgebra::{DMatrix, DVector, Dyn, LU};

/// The factors.
pub struct TreeFactors {
    stages: Scaled,
    end: DMatrix<f64>,
    masses: Scaled,
}

/// Factors of a matrix whose rows are divided by powers of two near their largest entries, so that pivots compare light joints with heavy ones.
struct Scaled {
    factors: LU<f64, Dyn, Dyn>,
    scales: DVector<f64>,
}

impl Scaled {
    /// `None` if the matrix is singular.
    fn new(mut matrix: DMatrix<f64>) -> Option<Self> {
        let scale = |largest: f64| if largest > 0.0 { (-largest.log2().round()).exp2() } else { 1.0 };
        let scales = DVector::from_iterator(matrix.nrows(), matrix.row_iter().map(|row| scale(row.amax())));
        for mut column in matrix.column_iter_mut() {
            column.component_mul_assign(&scales);
        }
        let factors = matrix.lu();
        factors.is_invertible().then_some(Scaled { factors, scales })
    }

    /// A x = b.
    fn solve(&self, right: &mut DMatrix<f64>) -> Option<()> {
        for mut column in right.column_iter_mut() {
            column.component_mul_assign(&self.scales);
        }
        self.factors.solve_mut(right).then_some(())
    }

    /// Aᵀ x = b, from P S A = L U: Uᵀ y = b, Lᵀ P S⁻¹ x = y.
    fn solve_transposed(&self, mut right: DVector<f64>) -> Option<DVector<f64>> {
        let is_solved = self.factors.u().tr_solve_upper_triangular_mut(&mut right)
            && self.factors.l().tr_solve_lower_triangular_mut(&mut right);
        self.factors.p().inv_permute_rows(&mut right);
        right.component_mul_assign(&self.scales);
        is_solved.then_some(right)
    }
}

impl TreeFactors {
    /// The factors of S, E and M; `None` if S or M is singular.
    pub fn new(stages: DMatrix<f64>, end: DMatrix<f64>, masses: DMatrix<f64>) -> Option<TreeFactors> {
        Some(TreeFactors { stages: Scaled::new(stages)?, end, masses: Scaled::new(masses)? })
    }

    /// `R_u⁻ᵀ` times weights of the displacements at the end and of v̄ (n each).
    pub fn solve_transposed(&self, displacements: &DVector<f64>, velocities: &DVector<f64>) -> Option<DVector<f64>> {
        let (n, many) = self.end.shape();
        let last = self.masses.solve_transposed(velocities.clone())?;
        let mut right = -self.end.tr_mul(&last);
        let mut of_end = right.rows_mut(many - n, n);
        of_end += displacements;
        let first = self.stages.solve_transposed(right)?;
        let mut all = DVector::zeros(many + n);
        all.rows_mut(0, many).copy_from(&first);
        all.rows_mut(many, n).copy_from(&last);
        Some(all)
    }
}

impl TreeFactors {
    /// Displacements and v̄ for right-hand sides.
    pub fn solve(&self, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let (n, many) = self.end.shape();
        let mut found = right.clone();
        let mut stages = right.rows(0, many).into_owned();
        self.stages.solve(&mut stages)?;
        let mut end = right.rows(many, n) - &self.end * &stages;
        self.masses.solve(&mut end)?;
        found.rows_mut(0, many).copy_from(&stages);
        found.rows_mut(many, n).copy_from(&end);
        Some(found)
    }
}

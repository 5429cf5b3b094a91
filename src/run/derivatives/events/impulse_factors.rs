//! The factors of the matrix of an impact, also where contacts are redundant.
//!
//! ```text
//!     A = L U                          regular
//!     R A C = U Σ Vᵀ                   redundant: A⁺ = C V Σ⁺ Uᵀ R        R, C: scales of rows and columns, so that entries are near 1
//! ```
//!
//! Four corners of a box that fall flat have one velocity after the impact, and many impulses. A⁺ gives the velocity, and the impulses nearest to the
//! run.
//!
//! Source: D. Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices, RAL-TR-2001-034; G. H. Golub, C. F. Van Loan, Matrix
//! Computations, 4th edition 2013, section 5.5.

use nalgebra::{DMatrix, DVector, Dyn, LU, SVD};

/// Rounds of scaling; entries are within some per cent of 1 then.
const ROUNDS: usize = 6;
/// Singular values below this part of the largest are zero: rows have roundings of 1e-15, and mechanisms near a gimbal lock have masses of 1e-10.
const SMALL: f64 = 1e-12;

/// The factors.
pub(super) enum ImpulseFactors {
    Regular(LU<f64, Dyn, Dyn>),
    Redundant(Box<Redundant>),
}

/// The factors of a singular matrix.
pub(super) struct Redundant {
    matrix: DMatrix<f64>,
    rows: DVector<f64>,
    columns: DVector<f64>,
    values: SVD<f64, Dyn, Dyn>,
    least: f64,
}

impl ImpulseFactors {
    /// `None` for entries that are not finite.
    pub fn of(matrix: DMatrix<f64>) -> Option<Self> {
        if matrix.iter().any(|entry| !entry.is_finite()) {
            return None;
        }
        let (rows, columns) = scales(&matrix);
        let scaled = DMatrix::from_diagonal(&rows) * &matrix * DMatrix::from_diagonal(&columns);
        let pivots = scaled.clone().lu().u().diagonal();
        let is_regular = pivots.iter().all(|pivot| pivot.abs() > SMALL);
        if is_regular {
            return Some(ImpulseFactors::Regular(matrix.lu()));
        }
        let values = scaled.try_svd(true, true, f64::EPSILON, 1000)?;
        let least = SMALL * values.singular_values.max();
        Some(ImpulseFactors::Redundant(Box::new(Redundant { matrix, rows, columns, values, least })))
    }

    /// The unknowns for right-hand sides; nearest to zero where there are many.
    pub fn solve(&self, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        match self {
            ImpulseFactors::Regular(factors) => factors.solve(right),
            ImpulseFactors::Redundant(of) => {
                let scaled = DMatrix::from_diagonal(&of.rows) * right;
                let found = of.values.solve(&scaled, of.least).ok()?;
                Some(DMatrix::from_diagonal(&of.columns) * found)
            }
        }
    }

    /// The most that the rows from `first` on lack at an answer, for each right-hand side: redundant rows may contradict each other.
    pub fn lacking(&self, found: &DMatrix<f64>, right: &DMatrix<f64>, first: usize) -> Vec<f64> {
        match self {
            ImpulseFactors::Regular(_) => vec![0.0; right.ncols()],
            ImpulseFactors::Redundant(of) => {
                let off = &of.matrix * found - right;
                off.column_iter().map(|column| column.rows_range(first..).amax()).collect()
            }
        }
    }
}

/// The scales of rows and columns.
fn scales(matrix: &DMatrix<f64>) -> (DVector<f64>, DVector<f64>) {
    let mut rows = DVector::from_element(matrix.nrows(), 1.0);
    let mut columns = DVector::from_element(matrix.ncols(), 1.0);
    let root = |size: f64| if size > 0.0 { 1.0 / size.sqrt() } else { 1.0 };
    for _ in 0..ROUNDS {
        let scaled = DMatrix::from_diagonal(&rows) * matrix * DMatrix::from_diagonal(&columns);
        for (scale, row) in rows.iter_mut().zip(scaled.row_iter()) {
            *scale *= root(row.amax());
        }
        for (scale, column) in columns.iter_mut().zip(scaled.column_iter()) {
            *scale *= root(column.amax());
        }
    }
    (rows, columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn redundant_rows_give_the_nearest_unknowns_and_say_what_they_lack() {
        // A mass of 2 kg on two equal stops, in units a thousand apart.
        let matrix = DMatrix::from_row_slice(3, 3, &[2.0, -1.0, -1e3, 1.0, 0.0, 0.0, 1e3, 0.0, 0.0]);
        let factors = ImpulseFactors::of(matrix).expect("finite entries");
        assert!(matches!(factors, ImpulseFactors::Redundant(_)));
        let right = DMatrix::from_row_slice(3, 2, &[6.0, 0.0, 3.0, 1.0, 3e3, 0.0]);
        let found = factors.solve(&right).expect("an answer");
        assert!((found[(0, 0)] - 3.0).abs() < 1e-12 && found[(1, 0)].abs() < 1e-12, "{found}");
        let lacking = factors.lacking(&found, &right, 1);
        assert!(lacking[0] < 1e-9 && lacking[1] > 0.1, "{lacking:?}");
    }
}

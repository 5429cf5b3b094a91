//! Independent coordinates: which joints tell the motion of a mechanism with closures.
//!
//! Gaussian elimination of G (m × n) with complete pivoting ends after `rank` pivots. Their rows are independent equations, their columns the
//! degrees of freedom that depend on all others:
//!
//! ```text
//!     G_D w_D + G_I w_I = 0        w = T w_I        T_I = 1,  T_D = −G_D⁻¹ G_I
//! ```
//!
//! Contacts that roll have equations of velocities alone, R w = 0: of the velocities fewer are independent than of the positions. The elimination goes
//! on with R T.

use nalgebra::{DMatrix, DVector};

/// Pivots below this part of the largest are zero: redundant equations leave roundings.
const RANK: f64 = 1e-9;

/// The split of rows and degrees of freedom.
#[derive(Clone, Debug)]
pub struct Independent {
    /// Independent equations.
    pub rows: Vec<usize>,
    /// The degrees of freedom that follow, as many.
    pub dependent: Vec<usize>,
    /// All others, in their order (d).
    pub independent: Vec<usize>,
}

/// The splits of positions, and of velocities, which are some of the independent positions.
pub struct BothIndependent {
    pub positions: Independent,
    pub velocities: Independent,
}

impl BothIndependent {
    /// The splits for a gradient whose first rows are the closures of positions; without an answer if their pivots are singular.
    pub fn of(gradient: &DMatrix<f64>, of_positions: usize, weights: &[f64]) -> Option<Self> {
        let closed = gradient.rows(0, of_positions).into_owned();
        let positions = Independent::of(&closed, weights);
        let rolling = gradient.rows(of_positions, gradient.nrows() - of_positions);
        if rolling.is_empty() {
            return Some(BothIndependent { velocities: positions.clone(), positions });
        }
        let own: Vec<f64> = positions.independent.iter().map(|&freedom| weights[freedom]).collect();
        let largest = rolling.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
        let further = Independent::beside(&(rolling * positions.motions(&closed)?), &own, largest);
        let freedom = |own: &usize| positions.independent[*own];
        let rows = positions.rows.iter().copied().chain(further.rows.iter().map(|row| of_positions + row));
        let dependent = positions.dependent.iter().copied().chain(further.dependent.iter().map(freedom));
        let velocities = Independent {
            rows: rows.collect(),
            dependent: dependent.collect(),
            independent: further.independent.iter().map(freedom).collect(),
        };
        Some(BothIndependent { positions, velocities })
    }
}

impl Independent {
    /// The split for a gradient G (m × n); degrees of freedom with larger weights (n) are more likely to depend on others.
    pub fn of(gradient: &DMatrix<f64>, weights: &[f64]) -> Self {
        Independent::beside(gradient, weights, 0.0)
    }

    /// The same beside entries of this size, against which pivots are roundings.
    fn beside(gradient: &DMatrix<f64>, weights: &[f64], mut largest: f64) -> Self {
        let (m, n) = gradient.shape();
        let mut left = DMatrix::from_fn(m, n, |row, column| gradient[(row, column)] * weights[column]);
        let (mut rows, mut dependent) = (Vec::new(), Vec::new());
        while rows.len() < m.min(n) {
            let free = |taken: &[usize], of: usize| !taken.contains(&of);
            let places = (0..m).filter(|&row| free(&rows, row));
            let places = places.flat_map(|row| (0..n).map(move |column| (row, column)));
            let places = places.filter(|&(_, column)| free(&dependent, column));
            let Some((row, column)) = places.max_by(|&one, &other| left[one].abs().total_cmp(&left[other].abs()))
            else {
                break;
            };
            let pivot = left[(row, column)];
            largest = largest.max(pivot.abs());
            if pivot.abs() <= RANK * largest || !pivot.is_finite() {
                break;
            }
            for other in (0..m).filter(|&other| other != row && free(&rows, other)) {
                let factor = left[(other, column)] / pivot;
                (0..n).for_each(|column| left[(other, column)] -= factor * left[(row, column)]);
            }
            rows.push(row);
            dependent.push(column);
        }
        let independent = (0..n).filter(|column| !dependent.contains(column)).collect();
        Independent { rows, dependent, independent }
    }

    /// T (n × d), unless the pivots are singular.
    pub fn motions(&self, gradient: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let d = self.independent.len();
        self.solve(gradient, &DMatrix::zeros(gradient.nrows(), d), &DMatrix::identity(d, d))
    }

    /// The solution w (n × k) of `G w = b` (m × k) with `w_I` (d × k); `None` if the pivots are singular.
    pub fn solve(&self, gradient: &DMatrix<f64>, right: &DMatrix<f64>, own: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let Independent { rows, dependent, independent } = self;
        let count = own.ncols();
        let mut whole = DMatrix::zeros(gradient.ncols(), count);
        independent.iter().enumerate().for_each(|(row, &freedom)| whole.set_row(freedom, &own.row(row)));
        if rows.is_empty() {
            return Some(whole);
        }
        let missing = (right - gradient * &whole).select_rows(rows);
        let square = gradient.select_rows(rows).select_columns(dependent);
        let found = square.lu().solve(&missing)?;
        dependent.iter().enumerate().for_each(|(row, &freedom)| whole.set_row(freedom, &found.row(row)));
        Some(whole)
    }

    /// The multipliers λ (m) with `(Gᵀ λ)_D = b_D`, zero for redundant equations; `None` if the pivots are singular.
    pub fn multipliers(&self, gradient: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
        let Independent { rows, dependent, .. } = self;
        let mut multipliers = DVector::zeros(gradient.nrows());
        if !rows.is_empty() {
            let square = gradient.select_rows(rows).select_columns(dependent).transpose();
            let found = square.lu().solve(&right.select_rows(dependent))?;
            rows.iter().zip(found.iter()).for_each(|(&row, &found)| multipliers[row] = found);
        }
        Some(multipliers)
    }
}

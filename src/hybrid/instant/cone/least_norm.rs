//! The solution of least norm of a square system that may be singular, and its null vectors.
//!
//! ```text
//!     A P = Q R      R₁₁ (r × r) regular, what is below it rounding        columns by their size: Householder with pivoting
//!     x = P (R₁₁⁻¹ Qᵀ b, 0) − N Nᵀ (…)                                     N (n × (n − r)) orthonormal, of P (−R₁₁⁻¹ R₁₂, 1)
//! ```
//!
//! A matrix that falls apart is solved part by part, each with its own rank.
//!
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th edition, sections 5.4.2 and 5.5.6.

use crate::instant::cone::apart::{parts_of, sub_matrix};
use nalgebra::{DMatrix, DVector};

/// Pivots below this part of the largest of their part are zero.
const SINGULAR: f64 = 1e-11;

/// x, and N; x solves the system as far as it can be solved. `None` if a number is not finite.
pub(crate) fn least_norm(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let count = right.len();
    if count == 0 {
        return Some((DVector::zeros(0), DMatrix::zeros(0, 0)));
    }
    if !matrix.iter().chain(right.iter()).all(|value| value.is_finite()) {
        return None;
    }
    let parts = parts_of(matrix);
    if parts.len() == 1 {
        return of_part(matrix, right);
    }
    let mut solution = DVector::zeros(count);
    let mut columns = Vec::new();
    for part in &parts {
        let own = DVector::from_fn(part.len(), |place, _| right[part[place]]);
        let (found, null) = of_part(&sub_matrix(matrix, part), &own)?;
        part.iter().zip(&found).for_each(|(&row, value)| solution[row] = *value);
        columns.extend(null.column_iter().map(|column| spread(part, column.iter(), count)));
    }
    let null = if columns.is_empty() { DMatrix::zeros(count, 0) } else { DMatrix::from_columns(&columns) };
    Some((solution, null))
}

/// The values of a part among all rows.
pub(crate) fn spread<'v>(part: &[usize], values: impl Iterator<Item = &'v f64>, count: usize) -> DVector<f64> {
    let mut all = DVector::zeros(count);
    part.iter().zip(values).for_each(|(&row, value)| all[row] = *value);
    all
}

/// The same of a matrix that does not fall apart.
fn of_part(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let count = right.len();
    let factors = matrix.clone().col_piv_qr();
    let upper = factors.r();
    let largest = upper[(0, 0)].abs();
    let rank = (0..count).take_while(|&row| upper[(row, row)].abs() > SINGULAR * largest).count();
    let turned = factors.q().transpose() * right;
    let regular = upper.view((0, 0), (rank, rank)).into_owned();
    let mut solution = DVector::zeros(count);
    solution.rows_mut(0, rank).copy_from(&regular.solve_upper_triangular(&turned.rows(0, rank).into_owned())?);
    let mut null = DMatrix::zeros(count, count - rank);
    if rank < count {
        let others = upper.view((0, rank), (rank, count - rank)).into_owned();
        null.rows_mut(0, rank).copy_from(&-regular.solve_upper_triangular(&others)?);
        null.rows_mut(rank, count - rank).fill_with_identity();
    }
    factors.p().inv_permute_rows(&mut solution);
    factors.p().inv_permute_rows(&mut null);
    if rank < count {
        null = null.qr().q();
        let idle = null.transpose() * &solution;
        solution -= &null * idle;
    }
    Some((solution, null))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::scenes::Random;

    #[test]
    fn the_solution_is_the_shortest_and_null_vectors_do_nothing() {
        let mut random = Random::new(5);
        for round in 0..200 {
            let count = 1 + round % 9;
            let rank = 1 + (round / 9) % count;
            let [left, right] = [0, 1].map(|_| DMatrix::from_fn(rank, count, |_, _| random.signed()));
            let matrix = left.transpose() * right;
            let wanted = DVector::from_fn(count, |_, _| random.signed());
            let (found, null) = least_norm(&matrix, &(&matrix * &wanted)).expect("finite");
            assert_eq!(null.ncols(), count - rank, "round {round}");
            let scale = matrix.amax();
            assert!((&matrix * (&found - &wanted)).amax() <= 1e-9 * scale, "round {round}");
            assert!((&matrix * &null).amax() <= 1e-11 * scale && (null.transpose() * &found).amax() <= 1e-9);
        }
    }

    #[test]
    fn parts_of_a_matrix_are_solved_as_if_they_were_alone_however_their_sizes_differ() {
        // A part that is 1e13 times as light as another one, with its rows between the rows of that: its pivots are not zero beside the others.
        let heavy = DMatrix::from_row_slice(2, 2, &[2e13, 1e13, 1e13, 2e13]);
        let light = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        let places = [[0, 2], [1, 3]];
        let mut matrix = DMatrix::zeros(4, 4);
        for (part, own) in [&heavy, &light].into_iter().zip(places) {
            (0..4).for_each(|entry| matrix[(own[entry / 2], own[entry % 2])] = part[(entry / 2, entry % 2)]);
        }
        let (found, null) = least_norm(&matrix, &DVector::from_column_slice(&[3e13, 2.0, 3e13, 2.0])).expect("finite");
        assert!((found - DVector::repeat(4, 1.0)).amax() < 1e-14);
        assert_eq!(null.ncols(), 1);
        assert!((null[(1, 0)] + null[(3, 0)]).abs() < 1e-15 && null[(0, 0)] == 0.0 && null[(2, 0)] == 0.0, "{null}");
    }

    #[test]
    fn four_corners_of_a_box_under_one_load_are_solved_to_rounding() {
        // The mobility of four points of a rigid body along three axes has rank 6, and singular values that repeat.
        let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]];
        let row = |index: usize| {
            let ([x, y], z) = (corners[index / 3], -0.25);
            let unit = [0, 1, 2].map(|axis| if axis == index % 3 { 1.0 } else { 0.0 });
            let [a, b, c] = unit;
            [a, b, c, y * c - z * b, z * a - x * c, x * b - y * a]
        };
        let weights = [1.0, 1.0, 1.0, 2.8, 2.8, 1.5];
        let matrix = DMatrix::from_fn(12, 12, |i, j| (0..6).map(|k| row(i)[k] * weights[k] * row(j)[k]).sum());
        let right = DVector::from_fn(12, |index, _| [-3.7, 0.0, 9.0][index % 3]);
        let (found, null) = least_norm(&matrix, &right).expect("finite");
        assert_eq!(null.ncols(), 6);
        assert!((matrix * found - right).amax() < 1e-13);
    }
}

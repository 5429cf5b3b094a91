//! The factors of a dense matrix, by Gauss's elimination with row pivots.
//!
//! ```text
//!     P S A = L U          S: powers of two near the reciprocals of the largest entries of the rows
//! ```
//!
//! The scales let pivots compare the rows of light joints with those of heavy ones. Rows are eliminated four pivots at a time, so that each entry is
//! loaded and stored once for four. The loops run in the widest vectors of the processor, with the same roundings on all.
//!
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th edition 2013, sections 3.2 and 3.4.

use crate::lobatto::numbers::lanes::Lanes;
use crate::lobatto::vectors::{InVectors, eight_in_portable};
#[cfg(target_arch = "x86_64")]
use crate::lobatto::vectors::{eight_in_avx2, eight_in_avx512};
#[cfg(not(target_arch = "x86_64"))]
use crate::lobatto::vectors::{no_vectors as eight_in_avx2, no_vectors as eight_in_avx512};
use nalgebra::{DMatrix, DVector};

/// Pivots that are eliminated together.
const PANEL: usize = 4;
/// Partial sums of a product of rows.
const SUMS: usize = 8;

/// The factors L and U.
pub struct Elimination {
    count: usize,
    /// L below the diagonal and U above, row by row; the diagonal has the reciprocals of the pivots.
    rows: Vec<f64>,
    /// The row of A that is in each row of the factors, and S by the rows of A.
    order: Vec<usize>,
    scales: Vec<f64>,
}

/// Work in wide vectors.
struct Widely<F>(F);

impl<R, F: FnOnce() -> R> InVectors for Widely<F> {
    type Output = R;
    #[inline(always)]
    fn with<V: Lanes>(self) -> R {
        V::run(self.0)
    }
}

impl Elimination {
    /// `None` if the matrix is singular.
    pub fn new(matrix: &DMatrix<f64>) -> Option<Self> {
        let count = matrix.nrows();
        let mut scales = vec![0.0; count];
        for column in matrix.column_iter() {
            scales.iter_mut().zip(&column).for_each(|(most, entry): (&mut f64, &f64)| *most = most.max(entry.abs()));
        }
        let scale = |largest: f64| if largest > 0.0 { (-largest.log2().round()).exp2() } else { 1.0 };
        scales.iter_mut().for_each(|entry| *entry = scale(*entry));
        let mut rows = vec![0.0; count * count];
        for (number, column) in matrix.column_iter().enumerate() {
            for (row, entry) in column.iter().enumerate() {
                rows[row * count + number] = scales[row] * entry;
            }
        }
        let mut found = Elimination { count, rows, order: (0..count).collect(), scales };
        found.eliminate_widely().then_some(found)
    }

    fn eliminate_widely(&mut self) -> bool {
        let done = eight_in_avx512(Widely(|| self.eliminate()));
        done.or_else(|| eight_in_avx2(Widely(|| self.eliminate())))
            .unwrap_or_else(|| eight_in_portable(Widely(|| self.eliminate())))
    }

    /// Whether all pivots are finite and not zero.
    #[inline(always)]
    fn eliminate(&mut self) -> bool {
        let count = self.count;
        for first in (0..count).step_by(PANEL) {
            let after = count.min(first + PANEL);
            for pivot in first..after {
                if !self.eliminate_within(pivot, after) {
                    return false;
                }
            }
            // U of the pivots, right of the panel.
            for pivot in first + 1..after {
                for above in first..pivot {
                    let (before, own) = self.rows.split_at_mut(pivot * count);
                    let factor = own[above];
                    subtract(&mut own[after..count], &before[above * count + after..][..count - after], factor);
                }
            }
            if after < first + PANEL {
                break;
            }
            let (before, below) = self.rows.split_at_mut(after * count);
            let pivots: [&[f64]; PANEL] =
                [0, 1, 2, 3].map(|number| &before[(first + number) * count + after..][..count - after]);
            for row in below.chunks_exact_mut(count) {
                let factors = [row[first], row[first + 1], row[first + 2], row[first + 3]];
                subtract_four(&mut row[after..], pivots, factors);
            }
        }
        true
    }

    /// Finds a pivot, and eliminates below it within the panel.
    #[inline(always)]
    fn eliminate_within(&mut self, pivot: usize, after: usize) -> bool {
        let count = self.count;
        let (mut best, mut largest) = (pivot, 0.0);
        for row in pivot..count {
            let size = self.rows[row * count + pivot].abs();
            if size > largest {
                (best, largest) = (row, size);
            }
        }
        if !(largest > 0.0 && largest < f64::INFINITY) {
            return false;
        }
        if best != pivot {
            self.order.swap(pivot, best);
            let (before, below) = self.rows.split_at_mut(best * count);
            before[pivot * count..][..count].swap_with_slice(&mut below[..count]);
        }
        let (before, below) = self.rows.split_at_mut((pivot + 1) * count);
        let own = &mut before[pivot * count..];
        own[pivot] = 1.0 / own[pivot];
        let own = &*own;
        for row in below.chunks_exact_mut(count) {
            row[pivot] *= own[pivot];
            let factor = row[pivot];
            for column in pivot + 1..after {
                row[column] -= factor * own[column];
            }
        }
        true
    }

    /// `A⁻¹ b`.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut found: Vec<f64> = self.order.iter().map(|&row| self.scales[row] * right[row]).collect();
        for row in 1..self.count {
            found[row] -= product(&self.rows[row * self.count..][..row], &found[..row]);
        }
        for row in (0..self.count).rev() {
            let own = &self.rows[row * self.count..][..self.count];
            found[row] = (found[row] - product(&own[row + 1..], &found[row + 1..])) * own[row];
        }
        found
    }

    /// `A⁻ᵀ b`, from `Uᵀ y = b` and `Lᵀ P S⁻¹ x = y`.
    pub fn solve_transposed(&self, mut right: Vec<f64>) -> Vec<f64> {
        let count = self.count;
        for row in 0..count {
            let own = &self.rows[row * count..][..count];
            let (before, later) = right.split_at_mut(row + 1);
            before[row] *= own[row];
            subtract(later, &own[row + 1..], before[row]);
        }
        for row in (1..count).rev() {
            let (before, later) = right.split_at_mut(row);
            subtract(before, &self.rows[row * count..][..row], later[0]);
        }
        let mut found = vec![0.0; count];
        for (&row, value) in self.order.iter().zip(right) {
            found[row] = self.scales[row] * value;
        }
        found
    }

    /// `A⁻¹ B`.
    pub fn solve_all(&self, right: &DMatrix<f64>) -> DMatrix<f64> {
        let mut found = right.clone();
        for (mut to, column) in found.column_iter_mut().zip(right.column_iter()) {
            to.copy_from(&DVector::from_vec(self.solve(column.as_slice())));
        }
        found
    }
}

/// `row − factor · other`.
#[inline(always)]
fn subtract(row: &mut [f64], other: &[f64], factor: f64) {
    row.iter_mut().zip(other).for_each(|(entry, other)| *entry -= factor * other);
}

/// The same for four rows.
#[inline(always)]
fn subtract_four(row: &mut [f64], [a, b, c, d]: [&[f64]; 4], factors: [f64; 4]) {
    let others = a.iter().zip(b).zip(c.iter().zip(d));
    for (entry, ((a, b), (c, d))) in row.iter_mut().zip(others) {
        *entry = *entry - factors[0] * a - factors[1] * b - factors[2] * c - factors[3] * d;
    }
}

/// Σ of the products of all entries, in sums side by side.
#[inline(always)]
fn product(one: &[f64], other: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (ones, others) = (one.chunks_exact(SUMS), other.chunks_exact(SUMS));
    let rest: f64 = ones.remainder().iter().zip(others.remainder()).map(|(one, other)| one * other).sum();
    for (one, other) in ones.zip(others) {
        for index in 0..SUMS {
            sums[index] += one[index] * other[index];
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix whose rows have sizes from 1e-12 to 1e12.
    fn matrix(count: usize) -> DMatrix<f64> {
        let entry = |row: usize, column: usize| {
            let seed = (64 * row + column) as u64;
            let mixed = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        DMatrix::from_fn(count, count, |row, column| entry(row, column) * 10.0_f64.powi(row as i32 % 25 - 12))
    }

    #[test]
    fn both_solves_give_the_unknowns_from_which_the_right_side_was_made_for_counts_with_and_without_a_whole_panel() {
        for count in [0, 1, 3, 4, 7, 56] {
            let matrix = matrix(count);
            let factors = Elimination::new(&matrix).expect("no singular matrix");
            let wanted = DVector::from_fn(count, |row, _| 1.0 + row as f64);
            let found = DVector::from_vec(factors.solve((&matrix * &wanted).as_slice()));
            // Conditions of the rows are up to 1e3, growth and sums of 56 terms a few hundred roundings.
            assert!((&found - &wanted).amax() <= 1e-10 * count as f64, "{count}: {found}");
            let weights = DVector::from_fn(count, |row, _| (1.0 + row as f64) * 10.0_f64.powi(12 - row as i32 % 25));
            let found = factors.solve_transposed(matrix.tr_mul(&weights).as_slice().to_vec());
            for (found, wanted) in found.iter().zip(weights.iter()) {
                assert!((found - wanted).abs() <= 1e-10 * count as f64 * wanted.abs(), "{count}: {found} and {wanted}");
            }
        }
    }

    #[test]
    fn a_singular_matrix_has_no_factors() {
        let mut matrix = matrix(6);
        matrix.row_mut(4).fill(0.0);
        assert!(Elimination::new(&matrix).is_none());
    }
}

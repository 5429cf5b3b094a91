//! The factors of a dense matrix, by Gauss's elimination with row pivots.
//!
//! ```text
//!     P S A = L U          S: powers of two near the reciprocals of the largest entries of the rows
//! ```
//!
//! The scales let pivots compare the rows of light joints with the rows of heavy ones. Rows are eliminated four pivots at a time, so that each entry is
//! loaded and stored once for four. The columns of these pivots lie side by side meanwhile. The loops run in the widest vectors of the processor, with
//! the same roundings on all.
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
        let entries = matrix.as_slice();
        let mut scales = vec![0.0_f64; count];
        for column in 0..count {
            let own = &entries[column * count..][..count];
            for row in 0..count {
                let size = own[row].abs();
                scales[row] = if size > scales[row] { size } else { scales[row] };
            }
        }
        scales.iter_mut().for_each(|entry| *entry = near_reciprocal(*entry));
        let mut rows = vec![0.0; count * count];
        for row in 0..count {
            let own = &mut rows[row * count..][..count];
            for column in 0..count {
                own[column] = scales[row] * entries[column * count + row];
            }
        }
        let mut found = Elimination { count, rows, order: (0..count).collect(), scales };
        let mut panel = vec![0.0; PANEL * count];
        let done = eight_in_avx512(Widely(|| found.eliminate(&mut panel)));
        let done = done.or_else(|| eight_in_avx2(Widely(|| found.eliminate(&mut panel))));
        done.unwrap_or_else(|| eight_in_portable(Widely(|| found.eliminate(&mut panel)))).then_some(found)
    }

    /// Whether all pivots are finite and not zero; `panel` is room for the columns of four pivots.
    #[inline(always)]
    fn eliminate(&mut self, panel: &mut [f64]) -> bool {
        let count = self.count;
        for first in (0..count).step_by(PANEL) {
            let after = count.min(first + PANEL);
            let panel = &mut panel[..(after - first) * (count - first)];
            if !self.eliminate_panel(first, panel) {
                return false;
            }
            // U of the pivots, right of the panel.
            for pivot in first + 1..after {
                let (before, own) = self.rows.split_at_mut(pivot * count);
                for above in first..pivot {
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
            for number in 0..count - after {
                let row = &mut below[number * count..][..count];
                let factors = [row[first], row[first + 1], row[first + 2], row[first + 3]];
                subtract_four(&mut row[after..], pivots, factors);
            }
        }
        true
    }

    /// Finds pivots and eliminates within the columns from `first` on, side by side in `panel`, and exchanges the rows.
    #[inline(always)]
    fn eliminate_panel(&mut self, first: usize, panel: &mut [f64]) -> bool {
        let count = self.count;
        let length = count - first;
        let width = panel.len() / length;
        for row in 0..length {
            let own = &self.rows[(first + row) * count + first..][..width];
            for column in 0..width {
                panel[column * length + row] = own[column];
            }
        }
        for pivot in 0..width {
            let (best, size) = largest(&panel[pivot * length + pivot..][..length - pivot]);
            if !(size > 0.0 && size < f64::INFINITY) {
                return false;
            }
            let best = pivot + best;
            if best != pivot {
                self.order.swap(first + pivot, first + best);
                let (above, below) = self.rows.split_at_mut((first + best) * count);
                above[(first + pivot) * count..][..count].swap_with_slice(&mut below[..count]);
                (0..width).for_each(|column| panel.swap(column * length + pivot, column * length + best));
            }
            let (before, later) = panel.split_at_mut((pivot + 1) * length);
            let own = &mut before[pivot * length..][..length];
            let reciprocal = 1.0 / own[pivot];
            own[pivot] = reciprocal;
            for row in pivot + 1..length {
                own[row] *= reciprocal;
            }
            for column in 0..width - pivot - 1 {
                let column = &mut later[column * length..][..length];
                let factor = column[pivot];
                subtract(&mut column[pivot + 1..], &own[pivot + 1..], factor);
            }
        }
        for row in 0..length {
            let own = &mut self.rows[(first + row) * count + first..][..width];
            for column in 0..width {
                own[column] = panel[column * length + row];
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

/// The power of two near the reciprocal of a size; 1 for zero.
fn near_reciprocal(size: f64) -> f64 {
    if size > 0.0 { (-size.log2().round()).exp2() } else { 1.0 }
}

// These loops count indices. Iterators over several slices would be made by calls, row by row.

/// `row − factor · other`.
#[inline(always)]
fn subtract(row: &mut [f64], other: &[f64], factor: f64) {
    let count = row.len().min(other.len());
    let (row, other) = (&mut row[..count], &other[..count]);
    for index in 0..count {
        row[index] -= factor * other[index];
    }
}

/// The same for four rows of the same length.
#[inline(always)]
fn subtract_four(row: &mut [f64], others: [&[f64]; 4], factors: [f64; 4]) {
    let count = row.len();
    let (a, b, c, d) = (&others[0][..count], &others[1][..count], &others[2][..count], &others[3][..count]);
    for index in 0..count {
        let both = row[index] - factors[0] * a[index] - factors[1] * b[index];
        row[index] = both - factors[2] * c[index] - factors[3] * d[index];
    }
}

/// Σ of the products of all entries, in sums side by side.
#[inline(always)]
fn product(one: &[f64], other: &[f64]) -> f64 {
    let count = one.len().min(other.len());
    let (one, other) = (&one[..count], &other[..count]);
    let mut sums = [0.0; SUMS];
    let mut first = 0;
    while first + SUMS <= count {
        for index in 0..SUMS {
            sums[index] += one[first + index] * other[first + index];
        }
        first += SUMS;
    }
    for index in first..count {
        sums[index - first] += one[index] * other[index];
    }
    let mut sum = 0.0;
    for part in sums {
        sum += part;
    }
    sum
}

/// The place of the largest entry, and its size.
#[inline(always)]
fn largest(entries: &[f64]) -> (usize, f64) {
    let (mut best, mut most) = (0, 0.0);
    for index in 0..entries.len() {
        let size = entries[index].abs();
        if size > most {
            (best, most) = (index, size);
        }
    }
    (best, most)
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

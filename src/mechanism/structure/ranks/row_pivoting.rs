//! Row-pivoted QR of a dense matrix: the largest row left is the next pivot.
//!
//! ```text
//!     while  |a_i| = max over the rows left  >  threshold · |first|:       first among preferred rows, while these leave more than 1e-2 |first|
//!         q = a_i / |a_i|,  q ← q − Qᵀ Q q,  q ← q / |q|          re-orthogonalised, so that Q stays orthonormal to rounding
//!         a_j ← a_j − (a_j · q) q   of all rows left
//! ```
//!
//! Rows keep their natural size: a row of pure rounding must not become a unit vector. Among rows that are equally long to 1e-6 the first is taken,
//! so that the remaining rows belong to the last loops, whatever the roundings. Source: modified Gram–Schmidt with pivoting, Å. Björck, Numerical
//! Methods for Least Squares Problems (1996), section 2.4.

/// Rows that are shorter than the longest by no more than this part of it count as equally long.
const EQUAL: f64 = 1e-6;

/// A preferred row goes first if more than this part of the first pivot is left of it.
const PREFERRED: f64 = 1e-2;

/// The result of the QR.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pivoted {
    /// The independent rows, in the order of the pivots.
    pub order: Vec<usize>,
    /// The length of each of them when it was taken.
    pub pivots: Vec<f64>,
    /// The longest that was left before each of them, of which a pivot is the first that is about as long.
    pub longest: Vec<f64>,
    /// Orthonormal vectors that span the rows.
    pub basis: Vec<Vec<f64>>,
    /// The rows that preferred ones alone imply.
    pub borne: Vec<usize>,
}

/// Decides which rows are independent: a row of which less than `threshold` times the first pivot is left is not.
pub fn pivoted(rows: Vec<Vec<f64>>, threshold: f64) -> Pivoted {
    let all = rows.len();
    pivoted_preferring(all, rows, threshold)
}

/// The same, where this number of rows at the beginning is preferred to the others.
pub fn pivoted_preferring(preferred: usize, mut rows: Vec<Vec<f64>>, threshold: f64) -> Pivoted {
    let mut found = Pivoted::default();
    let mut left: Vec<usize> = (0..rows.len()).collect();
    let width = rows.first().map_or(0, Vec::len);
    let mut others = false;
    loop {
        let norms: Vec<f64> = left.iter().map(|&row| norm(&rows[row])).collect();
        let longest = |norms: &[f64]| norms.iter().fold(0.0, |most: f64, &norm| most.max(norm));
        let largest = longest(&norms);
        let first = found.pivots.first().copied().unwrap_or(largest);
        let count = left.partition_point(|&row| row < preferred);
        let goes_on = longest(&norms[..count]) > PREFERRED * first && found.basis.len() < width;
        if !goes_on && !others {
            others = true;
            let vanish = left[count..].iter().zip(&norms[count..]).filter(|(_, norm)| **norm <= threshold * first);
            found.borne = vanish.map(|(row, _)| *row).collect();
        }
        if largest == 0.0 || !largest.is_finite() || largest <= threshold * first || found.basis.len() == width {
            return found;
        }
        let among = if goes_on { &norms[..count] } else { &norms[..] };
        let chosen = longest(among);
        let Some(place) = among.iter().position(|&norm| norm >= (1.0 - EQUAL) * chosen) else { return found };
        let row = left.remove(place);
        let mut unit = std::mem::take(&mut rows[row]);
        let length = norms[place];
        unit.iter_mut().for_each(|value| *value /= length);
        remove(&mut unit, &found.basis);
        let length = norm(&unit);
        unit.iter_mut().for_each(|value| *value /= length);
        for &other in &left {
            let along = dot(&rows[other], &unit);
            rows[other].iter_mut().zip(&unit).for_each(|(value, unit)| *value -= along * unit);
        }
        found.order.push(row);
        found.pivots.push(norms[place]);
        found.longest.push(largest);
        found.basis.push(unit);
    }
}

impl Pivoted {
    /// How many rows are independent for a larger threshold, which ends the same pivots earlier.
    pub fn rank_above(&self, threshold: f64) -> usize {
        let first = self.pivots.first().copied().unwrap_or(0.0);
        self.longest.iter().take_while(|&&longest| longest > threshold * first).count()
    }

    /// The part of each of `count` unit vectors that the rows do not span: the rows of the projection on the null space.
    pub fn null_parts(&self, count: usize) -> Vec<Vec<f64>> {
        (0..count)
            .map(|index| {
                let mut part = vec![0.0; count];
                if self.basis.len() < count {
                    part[index] = 1.0;
                    // Once leaves a part of rounding; twice is enough.
                    remove(&mut part, &self.basis);
                    remove(&mut part, &self.basis);
                }
                part
            })
            .collect()
    }
}

/// Removes the components along orthonormal vectors from a vector.
fn remove(vector: &mut [f64], basis: &[Vec<f64>]) {
    for unit in basis {
        let along = dot(vector, unit);
        vector.iter_mut().zip(unit).for_each(|(value, unit)| *value -= along * unit);
    }
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_others_imply_are_left_over_and_of_equally_long_ones_the_last() {
        let rows = vec![vec![1.0, 0.0, 1.0], vec![0.0, 2.0, 0.0], vec![1.0, 2.0, 1.0], vec![0.0, 2.0, 0.0]];
        let found = pivoted(rows, 1e-10);
        let mut order = found.order.clone();
        order.sort_unstable();
        assert_eq!((found.order[0], found.order.len()), (2, 2), "{found:?}");
        assert_eq!(order, [0, 2], "of rows of which equally much is left the first counts");
        let parts = found.null_parts(3);
        let of = |index: usize| norm(&parts[index]);
        // The null space is (1, 0, −1)/√2.
        assert!((of(0) - 0.5_f64.sqrt()).abs() < 1e-15 && of(1) < 1e-15, "{parts:?}");
    }

    #[test]
    fn preferred_rows_imply_others_where_they_are_not_nearly_implied_themselves() {
        let rows = |small: f64| vec![vec![1.0, 0.0], vec![1.0, small], vec![0.0, 3.0], vec![2.0, 0.0]];
        let both = pivoted_preferring(2, rows(0.1), 1e-10);
        assert_eq!((both.order, both.borne), (vec![1, 0], vec![2, 3]));
        let one = pivoted_preferring(2, rows(1e-3), 1e-10);
        assert_eq!((one.order, one.borne), (vec![0, 2], vec![3]));
        assert_eq!(pivoted_preferring(1, rows(0.1), 1e-10).borne, [3]);
        assert_eq!(pivoted(rows(0.1), 1e-10).order, [2, 3]);
    }

    #[test]
    fn nothing_and_no_numbers_have_no_rank() {
        assert_eq!(pivoted(Vec::new(), 1e-10), Pivoted::default());
        assert_eq!(pivoted(vec![vec![0.0; 3]], 1e-10), Pivoted::default());
        assert_eq!(pivoted(vec![vec![f64::NAN; 2], vec![f64::INFINITY; 2]], 1e-10).order.len(), 0);
    }
}

//! The least of a convex quadratic function in a box: the problem behind sticking, resting on limits and impacts.
//!
//! ```text
//!     minimise  ½ λᵀ D λ + bᵀ λ    subject to  lower ≤ λ ≤ upper
//!     ⇔   a = D λ + b:   a_i = 0 inside,   a_i ≥ 0 at the lower bound,   a_i ≤ 0 at the upper bound
//! ```
//!
//! with D (m × m) symmetric and positive semidefinite: rates or accelerations `a` that efforts or impulses `λ` leave. If D is singular, λ is not
//! unique, and `a` is. The method is the primal active-set method. It goes from a point inside to the least on the face of the free coordinates, and
//! stops at the first bound that is in the way. If no bound is in the way, it leaves the bound that pulls most. On each face the step is the one of
//! least norm. A problem that falls apart is solved part by part.
//!
//! Source: J. Nocedal, S. J. Wright, Numerical Optimization, Springer 2006, section 16.5.

use crate::instant::cone::apart::{parts_of, sub_matrix};
use nalgebra::{DMatrix, DVector};

/// Pivots of D below this part of the largest are rounding.
const SINGULAR: f64 = 1e-11;

/// The solution.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bounded {
    /// λ.
    pub efforts: Vec<f64>,
    /// Which bound each is at: −1 the lower, 1 the upper, 0 none.
    pub at: Vec<i8>,
    /// `a = D λ + b`.
    pub rest: Vec<f64>,
}

/// Solves the problem.
pub(crate) fn minimise(matrix: &DMatrix<f64>, offset: &[f64], bounds: &[(f64, f64)]) -> Bounded {
    let count = offset.len();
    let parts = parts_of(matrix);
    if parts.len() < 2 {
        return minimise_part(matrix, offset, bounds);
    }
    let mut all = Bounded { efforts: vec![0.0; count], at: vec![0; count], rest: vec![0.0; count] };
    for part in parts {
        let offset: Vec<f64> = part.iter().map(|&row| offset[row]).collect();
        let bounds: Vec<(f64, f64)> = part.iter().map(|&row| bounds[row]).collect();
        let found = minimise_part(&sub_matrix(matrix, &part), &offset, &bounds);
        for (place, &row) in part.iter().enumerate() {
            (all.efforts[row], all.at[row], all.rest[row]) = (found.efforts[place], found.at[place], found.rest[place]);
        }
    }
    all
}

/// The same of a problem that does not fall apart.
fn minimise_part(matrix: &DMatrix<f64>, offset: &[f64], bounds: &[(f64, f64)]) -> Bounded {
    let count = offset.len();
    let mut efforts: Vec<f64> = bounds.iter().map(|&(lower, upper)| 0.0_f64.max(lower).min(upper)).collect();
    let mut at: Vec<i8> = vec![0; count];
    let rest_of = |efforts: &[f64]| {
        let product = matrix * DVector::from_column_slice(efforts);
        product.iter().zip(offset).map(|(value, offset)| value + offset).collect::<Vec<f64>>()
    };
    let scale = |row: usize, efforts: &[f64]| {
        let terms = (0..count).map(|column| (matrix[(row, column)] * efforts[column]).abs());
        offset[row].abs() + terms.sum::<f64>()
    };
    // Coordinates that start at a bound may leave it at once; each round leaves or reaches one, and no set comes again.
    for _ in 0..50 * (count + 1) {
        let rest = rest_of(&efforts);
        let free: Vec<usize> = (0..count).filter(|&index| at[index] == 0).collect();
        let step = least_on_face(matrix, &rest, &free);
        let mut length = 1.0;
        let mut blocking = None;
        for (&index, &change) in free.iter().zip(&step) {
            let (lower, upper) = bounds[index];
            let room = if change < 0.0 { lower - efforts[index] } else { upper - efforts[index] };
            if change != 0.0 && room.abs() < length * change.abs() {
                length = (room / change).max(0.0);
                blocking = Some((index, if change < 0.0 { -1 } else { 1 }));
            }
        }
        for (&index, &change) in free.iter().zip(&step) {
            efforts[index] += length * change;
        }
        if let Some((index, side)) = blocking {
            at[index] = side;
            efforts[index] = if side < 0 { bounds[index].0 } else { bounds[index].1 };
            continue;
        }
        let rest = rest_of(&efforts);
        let pulls = |index: usize| f64::from(at[index]) * rest[index];
        let worst = (0..count).filter(|&index| at[index] != 0 && bounds[index].0 < bounds[index].1);
        let worst = worst.filter(|&index| pulls(index) > 1e-12 * scale(index, &efforts));
        match worst.max_by(|&a, &b| pulls(a).total_cmp(&pulls(b))) {
            Some(index) => at[index] = 0,
            None => break,
        }
    }
    let rest = rest_of(&efforts);
    Bounded { efforts, at, rest }
}

/// The least-norm solution of `D_FF d = −a_F`.
fn least_on_face(matrix: &DMatrix<f64>, rest: &[f64], free: &[usize]) -> Vec<f64> {
    if free.is_empty() {
        return Vec::new();
    }
    // Scaled to a unit diagonal, so that singularity does not depend on units.
    let size = |index: usize| matrix[(index, index)].max(0.0).sqrt();
    let inverse: Vec<f64> = free.iter().map(|&index| if size(index) > 0.0 { 1.0 / size(index) } else { 0.0 }).collect();
    let face = DMatrix::from_fn(free.len(), free.len(), |row, column| {
        matrix[(free[row], free[column])] * inverse[row] * inverse[column]
    });
    let right = DVector::from_fn(free.len(), |row, _| -rest[free[row]] * inverse[row]);
    let eigen = face.symmetric_eigen();
    let largest = eigen.eigenvalues.iter().fold(0.0_f64, |most, value| most.max(*value));
    let mut solution = DVector::zeros(free.len());
    for (index, &value) in eigen.eigenvalues.iter().enumerate() {
        if value > SINGULAR * largest {
            let vector = eigen.eigenvectors.column(index);
            solution += vector * (vector.dot(&right) / value);
        }
    }
    solution.iter().zip(&inverse).map(|(value, inverse)| value * inverse).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::scenes::Random;

    /// A matrix `BᵀB` of some rank with entries from a plain congruence.
    fn semidefinite(count: usize, rank: usize, random: &mut Random) -> DMatrix<f64> {
        let rows = DMatrix::from_fn(rank, count, |_, _| random.signed());
        rows.transpose() * rows
    }

    #[test]
    fn the_law_holds_in_random_boxes_of_any_rank() {
        let mut random = Random::new(3);
        for round in 0..500 {
            let count = 1 + round % 7;
            let rank = 1 + (round / 7) % count;
            let matrix = semidefinite(count, rank, &mut random);
            let load = DVector::from_fn(count, |_, _| random.signed());
            // In the range of D, as accelerations are.
            let offset: Vec<f64> = (&matrix * load).iter().copied().collect();
            let bounds: Vec<(f64, f64)> = (0..count)
                .map(|index| match index % 3 {
                    0 => (0.0, f64::INFINITY),
                    1 => (-0.3, 0.3),
                    _ => (-random.signed().abs(), random.signed().abs()),
                })
                .collect();
            let found = minimise(&matrix, &offset, &bounds);
            for index in 0..count {
                let (value, rest) = (found.efforts[index], found.rest[index]);
                let (lower, upper) = bounds[index];
                assert!(lower <= value && value <= upper, "round {round}: {value} not in {lower} … {upper}");
                let allowed = 1e-9;
                if value > lower + 1e-9 {
                    assert!(rest <= allowed, "round {round}, {index}: rest {rest:e} above the lower bound");
                }
                if value < upper - 1e-9 {
                    assert!(rest >= -allowed, "round {round}, {index}: rest {rest:e} below the upper bound");
                }
            }
        }
    }

    #[test]
    fn one_joint_sticks_below_its_bound_and_slides_beyond() {
        let matrix = DMatrix::from_element(1, 1, 0.5);
        let stuck = minimise(&matrix, &[0.2], &[(-0.45, 0.45)]);
        assert!((stuck.efforts[0] + 0.4).abs() < 1e-15 && stuck.at[0] == 0 && stuck.rest[0].abs() < 1e-16);
        let slides = minimise(&matrix, &[0.3], &[(-0.45, 0.45)]);
        assert!(slides.at[0] == -1 && (slides.rest[0] - 0.075).abs() < 1e-15);
    }
}

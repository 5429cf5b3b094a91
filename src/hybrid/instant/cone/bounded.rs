//! The least of a convex quadratic function in a box: the problem behind sticking, resting on limits, impacts and starts within limits.
//!
//! ```text
//!     minimise  ½ λᵀ D λ + bᵀ λ    subject to  lower ≤ λ ≤ upper
//!     ⇔   a = D λ + b:   a_i = 0 inside,   a_i ≥ 0 at the lower bound,   a_i ≤ 0 at the upper bound
//! ```
//!
//! with D (m × m) symmetric and positive semidefinite: rates or accelerations `a` that efforts or impulses `λ` leave. If D is singular, as at contacts and
//! joints that hold each other, λ is not unique, and `a` is. [`minimise`] solves such problems by the primal active-set method, part by part. It goes from a
//! point inside to the least on the face of the free coordinates, and stops at the first bound that is in the way. If no bound is in the way, it leaves the
//! bound that pulls most. On each face the step is the one of least norm.
//!
//! If D is definite, as a mass matrix is, [`minimise_definite`] takes the primal–dual active-set method: with the coordinates F that no bound holds,
//!
//! ```text
//!     D_FF λ_F = −b_F − D_FB λ_B
//! ```
//!
//! then every λ_F outside the box is set on its bound, and every bound that pulls (a_i < 0 at the lower, a_i > 0 at the upper) lets go, all of them
//! in one round. It is Newton's method on the conditions above and takes a few rounds whatever the size is (a hundred freedoms take the other method a
//! hundred rounds, with eigenvalues in each); a coordinate at a bound is exactly there. It may go round in circles: then the other method has the last word.
//!
//! Source: M. Hintermüller, K. Ito, K. Kunisch, The primal–dual active set strategy as a semismooth Newton method, SIAM J. Optim. 13 (2002),
//! section 2; J. Nocedal, S. J. Wright, Numerical Optimization, Springer 2006, section 16.5.

use crate::instant::cone::apart::{parts_of, sub_matrix, with_unit_diagonal};
use nalgebra::{DMatrix, DVector};

/// Pivots of D below this part of the largest are rounding.
const SINGULAR: f64 = 1e-11;
/// Pivots above this part of the largest make a matrix definite.
const DEFINITE: f64 = 1e-9;
/// A bound pulls if its rest is more than this part of the terms that it is the sum of.
const PULLS: f64 = 1e-12;
/// Largest number of rounds of the primal–dual method: it takes a handful or goes round in circles.
const ROUNDS: usize = 20;

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
        return primal(matrix, offset, bounds);
    }
    let mut all = Bounded { efforts: vec![0.0; count], at: vec![0; count], rest: vec![0.0; count] };
    for part in parts {
        let offset: Vec<f64> = part.iter().map(|&row| offset[row]).collect();
        let bounds: Vec<(f64, f64)> = part.iter().map(|&row| bounds[row]).collect();
        let found = primal(&sub_matrix(matrix, &part), &offset, &bounds);
        for (place, &row) in part.iter().enumerate() {
            (all.efforts[row], all.at[row], all.rest[row]) = (found.efforts[place], found.at[place], found.rest[place]);
        }
    }
    all
}

/// Solves a problem whose matrix is definite.
pub(crate) fn minimise_definite(matrix: &DMatrix<f64>, offset: &[f64], bounds: &[(f64, f64)]) -> Bounded {
    primal_dual(matrix, offset, bounds).unwrap_or_else(|| primal(matrix, offset, bounds))
}

/// The lower bound for −1, the upper one for 1.
fn bound_at((lower, upper): (f64, f64), side: i8) -> f64 {
    if side < 0 { lower } else { upper }
}

/// `D λ + b`.
fn rest_of(matrix: &DMatrix<f64>, offset: &[f64], efforts: &[f64]) -> Vec<f64> {
    let product = matrix * DVector::from_column_slice(efforts);
    product.iter().zip(offset).map(|(value, offset)| value + offset).collect()
}

/// The sum of the sizes of the terms of a row of `D λ + b`.
fn terms_of(matrix: &DMatrix<f64>, offset: &[f64], efforts: &[f64], row: usize) -> f64 {
    let terms = efforts.iter().enumerate().map(|(column, effort)| (matrix[(row, column)] * effort).abs());
    offset[row].abs() + terms.sum::<f64>()
}

/// The primal–dual active-set method; `None` if D is singular on a face, or if it goes round in circles.
fn primal_dual(matrix: &DMatrix<f64>, offset: &[f64], bounds: &[(f64, f64)]) -> Option<Bounded> {
    let count = offset.len();
    let has_room = |index: usize| bounds[index].0 < bounds[index].1;
    let mut at: Vec<i8> = (0..count).map(|index| if has_room(index) { 0 } else { -1 }).collect();
    for _ in 0..ROUNDS {
        let mut efforts: Vec<f64> = (0..count)
            .map(|index| match at[index] {
                0 => 0.0,
                side => bound_at(bounds[index], side),
            })
            .collect();
        let free: Vec<usize> = (0..count).filter(|&index| at[index] == 0).collect();
        let held = rest_of(matrix, offset, &efforts);
        for (&index, value) in free.iter().zip(definite_on_face(matrix, &held, &free)?) {
            efforts[index] = value;
        }
        let rest = rest_of(matrix, offset, &efforts);
        let mut changed = false;
        for index in (0..count).filter(|&index| has_room(index)) {
            let side = match at[index] {
                0 if efforts[index] < bounds[index].0 => -1,
                0 if efforts[index] > bounds[index].1 => 1,
                0 => 0,
                side if f64::from(side) * rest[index] > PULLS * terms_of(matrix, offset, &efforts, index) => 0,
                side => side,
            };
            changed |= side != at[index];
            at[index] = side;
        }
        if !changed {
            return Some(Bounded { efforts, at, rest });
        }
    }
    None
}

/// The solution of `D_FF λ_F = −a_F`; `None` if `D_FF` is singular.
fn definite_on_face(matrix: &DMatrix<f64>, rest: &[f64], free: &[usize]) -> Option<Vec<f64>> {
    let (face, inverse) = with_unit_diagonal(matrix, free);
    let factor = face.clone().cholesky()?;
    let pivots = factor.l_dirty().diagonal();
    if !pivots.iter().all(|pivot| pivot * pivot > DEFINITE) {
        return None;
    }
    let right = DVector::from_fn(free.len(), |row, _| -rest[free[row]] * inverse[row]);
    let mut solution = factor.solve(&right);
    // Once more for what rounding has left.
    solution += factor.solve(&(&right - &face * &solution));
    Some(solution.iter().zip(&inverse).map(|(value, inverse)| value * inverse).collect())
}

/// The primal active-set method.
fn primal(matrix: &DMatrix<f64>, offset: &[f64], bounds: &[(f64, f64)]) -> Bounded {
    let count = offset.len();
    let mut efforts: Vec<f64> = bounds.iter().map(|&(lower, upper)| 0.0_f64.max(lower).min(upper)).collect();
    let mut at: Vec<i8> = vec![0; count];
    // Coordinates that start at a bound may leave it at once; each round leaves or reaches one, and no set comes again.
    for _ in 0..50 * (count + 1) {
        let rest = rest_of(matrix, offset, &efforts);
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
            efforts[index] = bound_at(bounds[index], side);
            continue;
        }
        let rest = rest_of(matrix, offset, &efforts);
        let pulls = |index: usize| f64::from(at[index]) * rest[index];
        let worst = (0..count).filter(|&index| at[index] != 0 && bounds[index].0 < bounds[index].1);
        let worst = worst.filter(|&index| pulls(index) > PULLS * terms_of(matrix, offset, &efforts, index));
        match worst.max_by(|&a, &b| pulls(a).total_cmp(&pulls(b))) {
            Some(index) => at[index] = 0,
            None => break,
        }
    }
    let rest = rest_of(matrix, offset, &efforts);
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
    fn both_methods_find_the_same_least_in_boxes_of_a_definite_function() {
        let mut random = Random::new(5);
        let mut circles = 0;
        for round in 0..300 {
            let count = 1 + round % 40;
            let matrix = semidefinite(count, count, &mut random) + DMatrix::identity(count, count) * 1e-3;
            let offset: Vec<f64> = (0..count).map(|_| random.signed()).collect();
            let bounds: Vec<(f64, f64)> = (0..count)
                .map(|index| match index % 4 {
                    0 => (0.0, f64::INFINITY),
                    1 => (0.1, 0.1),
                    2 => (f64::NEG_INFINITY, f64::INFINITY),
                    _ => (-random.signed().abs(), random.signed().abs()),
                })
                .collect();
            let slow = primal(&matrix, &offset, &bounds);
            let Some(fast) = primal_dual(&matrix, &offset, &bounds) else {
                circles += 1;
                continue;
            };
            for index in 0..count {
                // Condition numbers up to 1e5 times the rounding of values of up to 1e3.
                let difference = (fast.efforts[index] - slow.efforts[index]).abs();
                assert!(difference < 1e-8, "round {round}, {index}: {difference:e}");
                if fast.at[index] != 0 {
                    assert_eq!(fast.efforts[index], bound_at(bounds[index], fast.at[index]), "round {round}, {index}");
                }
            }
        }
        assert!(circles <= 3, "{circles} of 300 went round in circles");
    }

    #[test]
    fn bounds_that_hold_are_reached_exactly_and_the_rest_follows() {
        let matrix = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 0.0, 1.0, 4.0, 1.0, 0.0, 1.0, 3.0]);
        let none = (f64::NEG_INFINITY, f64::INFINITY);
        // x = 0.3 at its bound, and 4 y + z = −x, y + 3 z = 0.
        let found = minimise_definite(&matrix, &[0.0; 3], &[(0.3, 0.9), none, none]).efforts;
        assert_eq!(found[0], 0.3);
        assert!((found[1] + 0.9 / 11.0).abs() < 1e-16 && (found[2] - 0.3 / 11.0).abs() < 1e-16, "{found:?}");
        // A bound that does not hold is let go, one without room is a constant.
        let found = minimise_definite(&matrix, &[0.0; 3], &[(-0.2, -0.2), (-9.0, 0.01), (0.0, 1.0)]).efforts;
        assert_eq!(found, [-0.2, 0.01, 0.0]);
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

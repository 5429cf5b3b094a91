//! A problem whose blocks fall apart: those without any mobility between them are problems of their own.
//!
//! ```text
//!     D = diag(D_1 … D_k)     after blocks are put in order:     cost Σ n_i³ in the place of (Σ n_i)³
//! ```
//!
//! Bodies that stand beside each other on a floor do not feel each other's forces.

use crate::instant::cone::problem::{Law, Problem};
use nalgebra::DMatrix;

/// The forces of all parts of a problem, each found by `forces_of`; of a problem that does not fall apart those of the whole.
pub(crate) fn forces_apart(problem: &Problem, forces_of: impl Fn(&Problem) -> Vec<f64>) -> Vec<f64> {
    let mut firsts = Vec::with_capacity(problem.laws.len());
    let mut rows = 0;
    for law in problem.laws {
        firsts.push(rows);
        rows += law.rows();
    }
    let parts = parts(problem, &firsts);
    if parts.len() < 2 {
        return forces_of(problem);
    }
    let mut forces = vec![0.0; rows];
    for part in parts {
        let own: Vec<usize> =
            part.iter().flat_map(|&block| firsts[block]..firsts[block] + problem.laws[block].rows()).collect();
        let mobility = DMatrix::from_fn(own.len(), own.len(), |row, column| problem.mobility[(own[row], own[column])]);
        let free: Vec<f64> = own.iter().map(|&row| problem.free[row]).collect();
        let laws: Vec<Law> = part.iter().map(|&block| problem.laws[block]).collect();
        let found = forces_of(&Problem { mobility: &mobility, free: &free, laws: &laws });
        own.iter().zip(found).for_each(|(&row, force)| forces[row] = force);
    }
    forces
}

/// The blocks that feel each other, in the order of their first.
fn parts(problem: &Problem, firsts: &[usize]) -> Vec<Vec<usize>> {
    let rows = |block: usize| firsts[block]..firsts[block] + problem.laws[block].rows();
    parts_joined(firsts.len(), |one, other| {
        rows(one).any(|row| rows(other).any(|column| problem.mobility[(row, column)] != 0.0))
    })
}

/// The numbers below a count in parts that are joined, directly or by others; each part in order, and the parts in the order of their first.
pub(crate) fn parts_joined(count: usize, joins: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..count).collect();
    let mut parts = Vec::new();
    while let Some(&first) = left.first() {
        let mut part = vec![first];
        left.remove(0);
        let mut place = 0;
        while place < part.len() {
            let own = part[place];
            left.retain(|&other| {
                let joined = joins(own, other);
                if joined {
                    part.push(other);
                }
                !joined
            });
            place += 1;
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_without_mobility_between_them_are_problems_of_their_own_and_the_forces_are_in_their_rows() {
        // Rows 0 and 3 feel each other, rows 1 and 2 nothing: each is handed over alone, in this order.
        let mut mobility = DMatrix::identity(4, 4);
        (mobility[(0, 3)], mobility[(3, 0)]) = (0.5, 0.5);
        let free = [1.0, 2.0, 3.0, 4.0];
        let laws = [Law::of_contact(0.0, None); 4];
        let seen = std::cell::RefCell::new(Vec::new());
        let forces = forces_apart(&Problem { mobility: &mobility, free: &free, laws: &laws }, |part| {
            seen.borrow_mut().push(part.free.to_vec());
            assert_eq!(part.mobility.nrows(), part.free.len());
            part.free.iter().map(|rate| 10.0 * rate).collect()
        });
        assert_eq!(*seen.borrow(), [vec![1.0, 4.0], vec![2.0], vec![3.0]]);
        assert_eq!(forces, [10.0, 20.0, 30.0, 40.0]);
    }
}

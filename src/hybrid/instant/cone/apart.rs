//! A problem whose blocks fall apart: those without any mobility between them are problems of their own.
//!
//! ```text
//!     D = diag(D_1 … D_k)     after blocks are put in order:     cost Σ n_i³ in the place of (Σ n_i)³
//! ```
//!
//! Bodies that stand beside each other on a floor do not feel each other's forces.

use crate::instant::cone::problem::{Answer, Law, Problem};
use crate::mechanism::ground::disjoint_sets::DisjointSets;
use nalgebra::DMatrix;
use std::ops::Range;

/// A part of a problem: its blocks and rows in the whole, and its own data.
pub(crate) struct Part {
    pub blocks: Vec<usize>,
    pub rows: Vec<usize>,
    mobility: DMatrix<f64>,
    free: Vec<f64>,
    laws: Vec<Law>,
}

impl Part {
    /// The problem of the part alone.
    pub fn problem(&self) -> Problem<'_> {
        Problem { mobility: &self.mobility, free: &self.free, laws: &self.laws }
    }

    /// Its part of an answer of the whole.
    pub fn answer_in(&self, whole: &Answer) -> Answer {
        let own = |values: &[f64]| self.rows.iter().map(|&row| values[row]).collect();
        Answer {
            forces: own(&whole.forces),
            rates: own(&whole.rates),
            states: self.blocks.iter().map(|&block| whole.states[block]).collect(),
            residual: whole.residual,
        }
    }

    /// Puts its answer into the answer of the whole, and the residual if it is worse.
    pub fn put_into(&self, whole: &mut Answer, own: &Answer) {
        for (place, &row) in self.rows.iter().enumerate() {
            (whole.forces[row], whole.rates[row]) = (own.forces[place], own.rates[place]);
        }
        self.blocks.iter().zip(&own.states).for_each(|(&block, state)| whole.states[block] = *state);
        whole.residual = whole.residual.max(own.residual);
    }
}

/// The parts of a problem; `None` if it does not fall apart.
pub(crate) fn parts_apart(problem: &Problem) -> Option<Vec<Part>> {
    let firsts = problem.starts().into_iter().zip(problem.laws);
    let ranges: Vec<Range<usize>> = firsts.map(|(first, law)| first..first + law.rows()).collect();
    let parts = Some(blocks_joined(problem.mobility, &ranges)).filter(|parts| parts.len() > 1)?;
    let part = |blocks: Vec<usize>| {
        let rows: Vec<usize> = blocks.iter().flat_map(|&block| ranges[block].clone()).collect();
        Part {
            mobility: sub_matrix(problem.mobility, &rows),
            free: rows.iter().map(|&row| problem.free[row]).collect(),
            laws: blocks.iter().map(|&block| problem.laws[block]).collect(),
            blocks,
            rows,
        }
    };
    Some(parts.into_iter().map(part).collect())
}

/// The forces of all parts of a problem, each found by `forces_of`; of a problem that does not fall apart those of the whole.
pub(crate) fn forces_apart(problem: &Problem, forces_of: impl Fn(&Problem) -> Vec<f64>) -> Vec<f64> {
    let Some(parts) = parts_apart(problem) else { return forces_of(problem) };
    let mut forces = vec![0.0; problem.free.len()];
    for part in parts {
        let found = forces_of(&part.problem());
        part.rows.iter().zip(found).for_each(|(&row, force)| forces[row] = force);
    }
    forces
}

/// The rows and columns with these numbers.
pub(crate) fn sub_matrix(matrix: &DMatrix<f64>, own: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(own.len(), own.len(), |row, column| matrix[(own[row], own[column])])
}

/// The same of a symmetric matrix, scaled to a unit diagonal, so that singularity does not depend on units; and the scales `1/√D_ii`.
pub(crate) fn with_unit_diagonal(matrix: &DMatrix<f64>, own: &[usize]) -> (DMatrix<f64>, Vec<f64>) {
    let scales: Vec<f64> = own.iter().map(|&index| matrix[(index, index)].sqrt().recip()).collect();
    let entry = |row: usize, column: usize| matrix[(own[row], own[column])] * scales[row] * scales[column];
    (DMatrix::from_fn(own.len(), own.len(), entry), scales)
}

/// The rows of a square matrix in parts without any entry between them.
pub(crate) fn parts_of(matrix: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let mut rows = DisjointSets::new(matrix.nrows());
    unite_entries(matrix, &mut rows);
    rows.parts()
}

/// The blocks that feel each other, each with a range of rows, in the order of their first; of a mobility whose zeros are symmetric.
pub(crate) fn blocks_joined(mobility: &DMatrix<f64>, ranges: &[Range<usize>]) -> Vec<Vec<usize>> {
    let mut owners = vec![None; mobility.nrows()];
    for (block, range) in ranges.iter().enumerate() {
        owners[range.clone()].fill(Some(block));
    }
    let mut blocks = DisjointSets::new(ranges.len());
    entries_of(mobility, |row, column| {
        if let (Some(one), Some(other)) = (owners[row], owners[column]) {
            blocks.unite(one, other);
        }
    });
    blocks.parts()
}

/// Unites the rows of a square matrix that have an entry between them.
pub(crate) fn unite_entries(matrix: &DMatrix<f64>, rows: &mut DisjointSets) {
    entries_of(matrix, |row, column| {
        rows.unite(row, column);
    });
}

/// Calls `found` for the row and the column of each entry of a matrix that is not zero.
pub(crate) fn entries_of(matrix: &DMatrix<f64>, mut found: impl FnMut(usize, usize)) {
    let rows = matrix.nrows().max(1);
    for (column, entries) in matrix.as_slice().chunks_exact(rows).enumerate() {
        // Most runs of a large matrix are empty.
        for (run, entries) in entries.chunks(RUN).enumerate() {
            if entries.iter().fold(false, |any, entry| any | (*entry != 0.0)) {
                let entries = entries.iter().enumerate().filter(|(_, entry)| **entry != 0.0);
                entries.for_each(|(place, _)| found(RUN * run + place, column));
            }
        }
    }
}

/// Entries that are looked at together.
const RUN: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::scenes::{Body, Random, Scene};
    use crate::instant::cone::sharing::with_vanishing_compliance;
    use crate::instant::cone::{margin, solve, solve_apart};
    use crate::mechanism::motion::contact_solvers::ContactSolvers;
    use nalgebra::Vector3;

    /// The literal twin: the numbers below a count in parts that are joined, directly or by others; each part in order, and the parts in the order of their first.
    fn parts_joined(count: usize, joins: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
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

    #[test]
    fn parts_found_entry_by_entry_are_those_found_pair_by_pair() {
        let mut random = Random::new(3);
        for (count, entries) in [(0, 0), (1, 0), (40, 0), (40, 15), (40, 30), (90, 60), (90, 200)] {
            let mut matrix = DMatrix::zeros(count, count);
            for _ in 0..entries {
                let mut place = || ((0.5 + 0.5 * random.signed()) * (count - 1) as f64) as usize;
                let (row, column) = (place(), place());
                (matrix[(row, column)], matrix[(column, row)]) = (-1e-30, 2.0);
            }
            let joins = |one: usize, other: usize| matrix[(one, other)] != 0.0;
            assert_eq!(parts_of(&matrix), parts_joined(count, joins), "{entries} entries among {count} rows");
            let ranges: Vec<Range<usize>> = (0..count).step_by(3).map(|row| row..count.min(row + 3)).collect();
            let joins = |one: usize, other: usize| {
                ranges[one].clone().any(|row| ranges[other].clone().any(|column| matrix[(row, column)] != 0.0))
            };
            assert_eq!(blocks_joined(&matrix, &ranges), parts_joined(ranges.len(), joins), "{entries} among {count}");
        }
    }

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

    /// Boxes that are pushed about on four corners each, three metres apart.
    fn boxes(pushes: &[[f64; 3]]) -> Scene {
        let body = |(number, push): (usize, &[f64; 3])| {
            let mass = 10.0_f64.powi(number as i32);
            let mut body = Body::cuboid(mass, [0.4, 0.3, 0.2], Vector3::new(3.0 * number as f64, 0.0, 0.1));
            (body.velocity, body.spin) = (Vector3::from(*push), Vector3::from(*push) * 0.3);
            body
        };
        let mut scene = Scene::new(pushes.iter().enumerate().map(body).collect());
        // In the order of corners, so that the rows of the boxes lie between each other.
        for (x, y) in [(-0.2, -0.15), (-0.2, 0.15), (0.2, -0.15), (0.2, 0.15)] {
            for body in 0..pushes.len() {
                let place = Vector3::new(3.0 * body as f64 + x, y, 0.0);
                scene.touch(body, None, place, Vector3::z(), Law::Contact { friction: 0.5 });
            }
        }
        scene.build(9.81)
    }

    #[test]
    fn bodies_that_do_not_feel_each_other_have_the_forces_and_margins_that_they_have_alone_to_the_last_bit() {
        let pushes = [[0.1, 0.0, -1.0], [4.0, 1.0, -0.3], [0.0, 0.2, 0.3], [20.0, 0.0, 0.0]];
        let alone: Vec<Scene> = (0..pushes.len())
            .map(|number| {
                let mut scene = boxes(&pushes);
                let own: Vec<usize> = (0..4).map(|corner| corner * pushes.len() + number).collect();
                let rows: Vec<usize> = own.iter().flat_map(|&block| 3 * block..3 * block + 3).collect();
                scene.mobility = sub_matrix(&scene.mobility, &rows);
                scene.free = rows.iter().map(|&row| scene.free[row]).collect();
                scene.laws.truncate(4);
                scene
            })
            .collect();
        let together = boxes(&pushes);
        let found = solve_apart(&together.problem(), &mut ContactSolvers::default()).expect("it has an answer");
        let shared = with_vanishing_compliance(&together.problem(), found.clone());
        for (number, one) in alone.iter().enumerate() {
            let own = solve(&one.problem(), None).expect("it has an answer");
            let own_shared = with_vanishing_compliance(&one.problem(), own.clone());
            for (found, own) in [(&found, &own), (&shared, &own_shared)] {
                for corner in 0..4 {
                    let first = 3 * (corner * pushes.len() + number);
                    assert_eq!(found.forces[first..first + 3], own.forces[3 * corner..3 * corner + 3], "box {number}");
                }
            }
        }
        let margins = alone.iter().map(|one| margin(&one.problem()));
        assert_eq!(margin(&together.problem()), margins.fold(f64::INFINITY, f64::min));
    }
}

//! The forces that a choice of equations among the rows of blocks determines: which rows are equations, and what their forces push with.
//!
//! ```text
//!     D̃ λ = −b,    D̃ = W Y W̃ᵀ            W, W̃, b: [`crate::events::forces::closed_forces`]
//!     (D̃ + Z (C Z)ᵀ) λ = −(1 − Z Zᵀ) b     if zᵀ W = 0 for the columns z of Z, and a contact slides: then zᵀ C λ = 0
//! ```
//!
//! in scaled rows, so that singularity does not depend on units.

use crate::instant::cone::apart::{parts_of, sub_matrix, unite_entries};
use crate::instant::cone::least_norm::least_norm;
use crate::instant::cone::problem::Law;
use crate::instant::cone::sharing::implied;
use crate::instant::holding::blocks::{Block, Of, least_answer};
use crate::mechanism::ground::disjoint_sets::DisjointSets;
use nalgebra::{DMatrix, DVector};

/// Held rows whose response is singular to this part are redundant.
const SINGULAR: f64 = 1e-10;
/// Combinations of rows with less than this of tangents that friction holds are of normals.
const PART: f64 = 1e-6;

/// Which rows are equations, and what their forces push with.
#[derive(Clone)]
pub(crate) struct Chosen {
    /// The row of each equation, and the rows along which its force pushes as well, with what it is multiplied by: −μ t of a contact that slides, −ρ t
    /// and −σ s of one that turns.
    equations: Vec<(usize, Vec<(usize, f64)>)>,
    /// Whether it is one of a contact, and whether it is a tangent that friction holds.
    touches: Vec<bool>,
    adheres: Vec<bool>,
    /// The rows of moments that stand for normal forces, and the rows of those.
    loads: Vec<[usize; 2]>,
    rows: usize,
}

impl Chosen {
    pub fn new(blocks: &[Block]) -> Self {
        let (mut equations, mut touches, mut rows) = (Vec::<(usize, Vec<(usize, f64)>)>::new(), Vec::new(), 0);
        let (mut normal, mut loads, mut adheres) = (0, Vec::new(), Vec::<bool>::new());
        for block in blocks {
            if let (Of::Moment { .. }, Some((normal, _))) = (block.of, equations.get(normal)) {
                loads.push([rows, *normal]);
            }
            let pushes = |friction: f64, direction: [f64; 2]| {
                [(rows + 1, -friction * direction[0]), (rows + 2, -friction * direction[1])]
            };
            match (block.of, block.law) {
                // The normal force of its contact pushes along its rows.
                (Of::Moment { .. }, Law::Sliding { friction, direction }) => {
                    equations[normal].1.extend(pushes(friction, direction));
                }
                (Of::Moment { spinning, .. }, _) => {
                    let count = if spinning { 1 } else { 2 };
                    equations.extend((rows + 1..=rows + count).map(|row| (row, Vec::new())));
                }
                (_, Law::Sliding { friction, direction }) => {
                    normal = equations.len();
                    equations.push((rows, pushes(friction, direction).to_vec()));
                }
                _ => {
                    normal = equations.len();
                    equations.extend((rows..rows + block.rows.len()).map(|row| (row, Vec::new())));
                }
            }
            let first = adheres.len();
            touches.resize(equations.len(), matches!(block.of, Of::Contact(_)));
            adheres.resize(equations.len(), matches!((block.of, block.law), (Of::Contact(_), Law::Contact { .. })));
            adheres[first..].iter_mut().take(1).for_each(|normal| *normal = false);
            rows += block.rows.len();
        }
        Chosen { equations, touches, adheres, loads, rows }
    }

    /// Whether no rows imply others.
    pub fn is_unique(&self, mobility: &DMatrix<f64>) -> bool {
        let all: Vec<usize> = (0..self.equations.len()).collect();
        is_regular(&self.square(mobility, false, &all))
    }

    /// D̃ of some equations, or without friction its symmetric part of the same rows.
    fn square(&self, mobility: &DMatrix<f64>, friction: bool, own: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(own.len(), own.len(), |row, column| {
            let (row, (column, pushes)) = (self.equations[own[row]].0, &self.equations[own[column]]);
            let along = mobility[(row, *column)];
            let pushes = pushes.iter().filter(|_| friction);
            pushes.fold(along, |along, (beside, factor)| along + factor * mobility[(row, *beside)])
        })
    }

    /// The equations in groups without any entry of D̃ between them; some of the groups may fall apart further.
    fn groups(&self, mobility: &DMatrix<f64>) -> Vec<Vec<usize>> {
        let mut rows = DisjointSets::new(mobility.nrows());
        unite_entries(mobility, &mut rows);
        for (row, pushes) in &self.equations {
            for (beside, _) in pushes {
                rows.unite(*row, *beside);
            }
        }
        let mut of_rows = vec![None; mobility.nrows()];
        for (equation, (row, _)) in self.equations.iter().enumerate() {
            of_rows[*row] = Some(equation);
        }
        let equations = |part: Vec<usize>| part.into_iter().filter_map(|row| of_rows[row]).collect::<Vec<_>>();
        rows.parts().into_iter().map(equations).filter(|group| !group.is_empty()).collect()
    }

    /// The scales that give the symmetric part a unit diagonal, so that singularity does not depend on units; zero for rows that nothing answers to.
    fn scales(&self, mobility: &DMatrix<f64>) -> Vec<f64> {
        let least = least_answer(mobility);
        let own = self.equations.iter().map(|(row, _)| mobility[(*row, *row)]);
        own.map(|own| if own > least { 1.0 / own.sqrt() } else { 0.0 }).collect()
    }

    /// [`Chosen::square`], scaled.
    fn scaled(&self, mobility: &DMatrix<f64>, friction: bool, scales: &[f64], own: &[usize]) -> DMatrix<f64> {
        let mut square = self.square(mobility, friction, own);
        for (column, &of_column) in own.iter().enumerate() {
            for (row, &of_row) in own.iter().enumerate() {
                square[(row, column)] = square[(row, column)] * scales[of_row] * scales[of_column];
            }
        }
        square
    }

    /// The compliance that all contacts share: the mean over their normals.
    fn even(&self, mobility: &DMatrix<f64>) -> f64 {
        let of_contacts = self.equations.iter().zip(&self.touches).filter(|(_, touches)| **touches);
        let (sum, contacts) =
            of_contacts.fold((0.0, 0), |(sum, count), ((row, _), _)| (sum + mobility[(*row, *row)], count + 1));
        sum / f64::from(contacts.max(1))
    }

    /// The combinations z of scaled rows of a part that vanish, and `C z` for the same compliance of all contacts, both in columns of length one.
    fn spread(&self, part: &[usize], plain: DMatrix<f64>, scales: &[f64], even: f64) -> Option<[DMatrix<f64>; 2]> {
        let columns = implied(plain)?;
        let matrix =
            |columns: &[DVector<f64>]| DMatrix::from_fn(part.len(), columns.len(), |row, index| columns[index][row]);
        let columns = matrix(&columns);
        let slides = part.iter().any(|&row| !self.equations[row].1.is_empty());
        let [bearing, rest] = parted(&columns, |place| slides && self.adheres[part[place]]);
        let weight = |row: usize| if self.touches[row] { even * scales[row] * scales[row] } else { 1.0 };
        let weighed = |columns: &DMatrix<f64>, counts: &dyn Fn(usize) -> bool| {
            let entry = |place: usize, column: usize| {
                if counts(part[place]) { columns[(place, column)] * weight(part[place]) } else { 0.0 }
            };
            let mut weighed = DMatrix::from_fn(part.len(), columns.ncols(), entry);
            weighed.column_iter_mut().for_each(|mut column| {
                column.normalize_mut();
            });
            weighed
        };
        let (of_tangents, of_all) = (weighed(&bearing, &|row| self.adheres[row]), weighed(&rest, &|_| true));
        let joined = |one: &DMatrix<f64>, other: &DMatrix<f64>| {
            let all: Vec<_> = one.column_iter().chain(other.column_iter()).map(|column| column.into_owned()).collect();
            matrix(&all)
        };
        Some([joined(&bearing, &rest), joined(&of_tangents, &of_all)])
    }

    /// λ of all rows: part by part of those that do not feel each other.
    pub fn solve(&self, mobility: &DMatrix<f64>, offset: &[f64], unique: bool) -> Vec<f64> {
        let count = self.equations.len();
        if count == 0 {
            return Vec::new();
        }
        let scales = self.scales(mobility);
        let slides = !unique && self.equations.iter().any(|(_, pushes)| !pushes.is_empty());
        let even = slides.then(|| self.even(mobility));
        let mut solution = vec![0.0; count];
        for group in self.groups(mobility) {
            let scaled = self.scaled(mobility, true, &scales, &group);
            let plain = even.map(|even| (self.scaled(mobility, false, &scales, &group), even));
            let mut joined = DisjointSets::new(group.len());
            unite_entries(&scaled, &mut joined);
            plain.iter().for_each(|(plain, _)| unite_entries(plain, &mut joined));
            for part in joined.parts() {
                let (own, equations) = (sub_matrix(&scaled, &part), part.iter().map(|&place| group[place]));
                let equations: Vec<usize> = equations.collect();
                let right = equations.iter().map(|&row| -offset[self.equations[row].0] * scales[row]);
                let right = DVector::from_iterator(part.len(), right);
                let direct = if unique {
                    own.clone().lu().solve(&right)
                } else if let Some((plain, even)) = &plain {
                    self.spread(&equations, sub_matrix(plain, &part), &scales, *even).and_then(|[implied, weighed]| {
                        let left = &right - &implied * (implied.transpose() * &right);
                        (&own + implied * weighed.transpose()).lu().solve(&left)
                    })
                } else {
                    None
                };
                let direct = direct.filter(|solution| solution.iter().all(|value| value.is_finite()));
                let found = direct.or_else(|| least_norm(&own, &right).map(|(solution, _)| solution));
                found.into_iter().for_each(|found| {
                    equations.iter().zip(found.iter()).for_each(|(&row, value)| solution[row] = *value);
                });
            }
        }
        let mut forces = vec![0.0; self.rows];
        for (index, (row, pushes)) in self.equations.iter().enumerate() {
            forces[*row] = solution[index] * scales[index];
            for (beside, factor) in pushes {
                forces[*beside] = factor * forces[*row];
            }
        }
        self.loads.iter().for_each(|&[row, normal]| forces[row] = forces[normal]);
        forces
    }
}

/// The same span of orthonormal columns, first those with a part in some rows, then those without any.
fn parted(columns: &DMatrix<f64>, is_some: impl Fn(usize) -> bool) -> [DMatrix<f64>; 2] {
    let some: Vec<usize> = (0..columns.nrows()).filter(|&row| is_some(row)).collect();
    if some.is_empty() || columns.ncols() == 0 {
        return [DMatrix::zeros(columns.nrows(), 0), columns.clone()];
    }
    let own = columns.select_rows(&some);
    let eigen = (own.transpose() * own).symmetric_eigen();
    let turned = |with: bool| {
        let of = (0..columns.ncols()).filter(|&index| (eigen.eigenvalues[index] > PART * PART) == with);
        columns * eigen.eigenvectors.select_columns(&of.collect::<Vec<_>>())
    };
    [turned(true), turned(false)]
}

/// Whether a response is regular, whatever the units of its rows.
fn is_regular(square: &DMatrix<f64>) -> bool {
    let least = least_answer(square);
    if square.diagonal().iter().any(|own| *own <= least) {
        return false;
    }
    let scale: Vec<f64> = square.diagonal().iter().map(|own| own.sqrt()).collect();
    let scaled = DMatrix::from_fn(square.nrows(), square.ncols(), |row, column| {
        square[(row, column)] / (scale[row] * scale[column])
    });
    parts_of(&scaled).into_iter().all(|part| {
        let values = sub_matrix(&scaled, &part).symmetric_eigenvalues();
        values.min() > SINGULAR * values.max()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_nothing_answers_to_but_roundings_has_no_force_and_makes_no_other() {
        // The tangent across the plane of a linkage in a plane, whose bodies are 1e-14 m beside it.
        let law = Law::Contact { friction: 0.5 };
        let blocks = [Block { of: Of::Contact(0), law, rows: vec![vec![0.0].into(); 3] }];
        let chosen = Chosen::new(&blocks);
        for (noise, own) in [(1e-14, 1e-28), (3e-13, 1e-27), (-1e-13, 0.0), (1e-14, -1e-29)] {
            let mobility = DMatrix::from_row_slice(3, 3, &[40.0, 3.0, noise, 3.0, 2e3, -noise, noise, -noise, own]);
            assert!(!chosen.is_unique(&mobility), "{noise:e}, {own:e}");
            for unique in [true, false] {
                let forces = chosen.solve(&mobility, &[-1.0, 2.0, 1e-13], unique);
                let determinant = 40.0 * 2e3 - 9.0;
                let wanted = [(2e3 + 6.0) / determinant, -(80.0 + 3.0) / determinant, 0.0];
                let off = forces.iter().zip(wanted).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
                assert!(off < 1e-12, "{forces:?} for {wanted:?}");
            }
        }
    }
}

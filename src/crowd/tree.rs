//! One tree: its independent freedoms, and its mass matrix with the factor.
//!
//! ```text
//!     M ← Eᵀ M E                       with closures: v = E v_i      (`closures.rs`)
//!     M̃ = M + b D + b² K = L Lᵀ        damping D and stiffness K within a step, b: the time in which they act (s)
//! ```

use crate::closures::Closures;
use nalgebra::Vector3;

/// One tree.
#[derive(Clone, Default)]
pub struct Tree {
    pub bodies: Vec<usize>,
    /// Its independent freedoms by their numbers in the mechanism.
    pub freedoms: Vec<usize>,
    /// These, and the ones that follow them.
    pub all: Vec<usize>,
    /// x₀.
    pub root: Vector3<f64>,
    /// M, and the factor L of M̃, row by row.
    pub mass: Vec<f64>,
    pub softened: Vec<f64>,
    factor: Vec<f64>,
    /// The inverses of the diagonal entries of L.
    reciprocals: Vec<f64>,
    /// M̃⁻¹ of a free body, which is asked for most often.
    inverse: Option<[[f64; 6]; 6]>,
    pub(crate) closures: Option<Box<Closures>>,
    /// M of all rates, where some follow others.
    pub(crate) unclosed: Vec<f64>,
}

impl Tree {
    /// Takes the independent freedoms by their numbers among all.
    pub(crate) fn lay_out(&mut self, independent: Vec<usize>) {
        self.freedoms.clear();
        self.freedoms.extend(independent.into_iter().map(|own| self.all[own]));
        let count = self.freedoms.len();
        for matrix in [&mut self.mass, &mut self.softened, &mut self.factor] {
            matrix.resize(count * count, 0.0);
        }
        self.reciprocals.resize(count, 0.0);
    }

    /// M of all rates.
    pub(crate) fn of_all(&mut self) -> &mut [f64] {
        if self.closures.is_some() { &mut self.unclosed } else { &mut self.mass }
    }

    /// Each of all freedoms in independent ones, by their places among these; `None` if all are independent.
    pub fn ways(&self) -> Option<&[Vec<(usize, f64)>]> {
        self.closures.as_ref().map(|closures| closures.ways())
    }

    /// Whether its dependent rates follow from the independent ones.
    pub(crate) fn is_fit(&self) -> bool {
        self.closures.as_ref().is_none_or(|closures| closures.is_fit())
    }

    /// M ← Eᵀ M E.
    pub(crate) fn gather_mass(&mut self) {
        let Tree { closures, unclosed, mass, freedoms, all, .. } = self;
        let Some(closures) = closures else { return };
        let (ways, wide, count) = (closures.ways(), all.len(), freedoms.len());
        mass.fill(0.0);
        let mut row = vec![0.0; count];
        for (entries, own) in unclosed.chunks_exact(wide.max(1)).zip(ways) {
            row.fill(0.0);
            for (entry, other) in entries.iter().zip(ways).filter(|(entry, _)| **entry != 0.0) {
                other.iter().for_each(|&(place, part)| row[place] += entry * part);
            }
            for &(place, part) in own {
                let target = &mut mass[place * count..(place + 1) * count];
                target.iter_mut().zip(&row).for_each(|(sum, entry)| *sum += part * entry);
            }
        }
        for row in 0..count {
            for column in 0..row {
                // Symmetric to the last bit.
                mass[row * count + column] = mass[column * count + row];
            }
        }
    }

    /// Writes the rates of its dependent freedoms, which follow from the independent ones.
    pub fn complete(&self, rates: &mut [f64]) {
        let Some(ways) = self.ways() else { return };
        for (&freedom, way) in self.all.iter().zip(ways) {
            let sum = |sum: f64, &(place, part): &(usize, f64)| sum + part * rates[self.freedoms[place]];
            if !matches!(way[..], [(place, _)] if self.freedoms[place] == freedom) {
                rates[freedom] = way.iter().fold(0.0, sum);
            }
        }
    }

    /// Sums of values of all freedoms along the independent ones: Eᵀ x.
    pub fn gather(&self, value: impl Fn(usize) -> f64, sums: &mut [f64]) {
        let Some(ways) = self.ways() else {
            sums.iter_mut().zip(&self.freedoms).for_each(|(sum, &freedom)| *sum += value(freedom));
            return;
        };
        for (&freedom, way) in self.all.iter().zip(ways) {
            let own = value(freedom);
            way.iter().for_each(|&(place, part)| sums[place] += part * own);
        }
    }

    /// Factors M̃ for dampings and stiffnesses of the freedoms of the mechanism, which act for a time (s); `false` if it is singular.
    pub fn factor(&mut self, time: f64, damping: &[f64], stiffness: &[f64]) -> bool {
        if !self.is_fit() {
            return false;
        }
        let count = self.freedoms.len();
        self.softened.copy_from_slice(&self.mass);
        let soft = |freedom: usize| time * (damping[freedom] + time * stiffness[freedom]);
        match &self.closures {
            None => {
                for (own, &freedom) in self.freedoms.iter().enumerate() {
                    self.softened[own * count + own] += soft(freedom);
                }
            }
            Some(closures) => {
                for (&freedom, way) in self.all.iter().zip(closures.ways()) {
                    let soft = soft(freedom);
                    for &(row, part) in way.iter().filter(|_| soft > 0.0) {
                        for &(column, other) in way {
                            self.softened[row * count + column] += soft * part * other;
                        }
                    }
                }
            }
        }
        for row in 0..count {
            for column in 0..=row {
                let (upper, lower) = self.factor.split_at(row * count);
                let left = &lower[..column];
                let other = if column == row { left } else { &upper[column * count..column * count + column] };
                let sum = left.iter().zip(other).fold(self.softened[row * count + column], |sum, (a, b)| sum - a * b);
                let entry = if column < row {
                    sum * self.reciprocals[column]
                } else if sum > 0.0 {
                    self.reciprocals[row] = 1.0 / sum.sqrt();
                    sum.sqrt()
                } else {
                    return false;
                };
                self.factor[row * count + column] = entry;
            }
        }
        self.inverse = None;
        if count == 6 && self.bodies.len() == 1 {
            let mut inverse = [[0.0; 6]; 6];
            for (row, entries) in inverse.iter_mut().enumerate() {
                entries[row] = 1.0;
                self.solve(entries);
            }
            self.inverse = Some(inverse);
        }
        true
    }

    /// x ← M̃⁻¹ x.
    pub fn solve(&self, x: &mut [f64]) {
        if let (Some(inverse), Ok(x)) = (&self.inverse, <&mut [f64; 6]>::try_from(&mut *x)) {
            // It is symmetric: rows are columns.
            let mut sums = [0.0; 6];
            for (row, entry) in inverse.iter().zip(x.iter()) {
                (0..6).for_each(|column| sums[column] += row[column] * entry);
            }
            *x = sums;
            return;
        }
        self.solve_lower(x);
        let count = self.freedoms.len();
        for row in (0..count).rev() {
            let value = x[row] * self.reciprocals[row];
            x[row] = value;
            let (before, own) = (&mut x[..row], &self.factor[row * count..row * count + row]);
            before.iter_mut().zip(own).for_each(|(entry, factor)| *entry -= factor * value);
        }
    }

    /// x ← L⁻¹ x.
    pub fn solve_lower(&self, x: &mut [f64]) {
        let count = self.freedoms.len();
        for row in 0..count {
            let own = &self.factor[row * count..row * count + row];
            let sum = own.iter().zip(&x[..row]).fold(x[row], |sum, (factor, entry)| sum - factor * entry);
            x[row] = sum * self.reciprocals[row];
        }
    }

    /// y ← y + M̃ x.
    pub fn add_softened(&self, x: &[f64], y: &mut [f64]) {
        multiply_add(&self.softened, x, y);
    }

    /// y ← y + M x.
    pub fn add_mass(&self, x: &[f64], y: &mut [f64]) {
        multiply_add(&self.mass, x, y);
    }
}

fn multiply_add(matrix: &[f64], x: &[f64], y: &mut [f64]) {
    for (row, sum) in matrix.chunks_exact(x.len().max(1)).zip(y) {
        *sum += row.iter().zip(x).map(|(entry, x)| entry * x).sum::<f64>();
    }
}

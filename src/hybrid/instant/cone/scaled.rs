//! A problem with the units taken out: each block has a mobility of mean 1.
//!
//! ```text
//!     w_c = tr(D_cc) / rows,   r = r̂ / √w_c,   u = û √w_c,   D̂ = D / √(w_c w_d),   b̂ = b / √w_c
//! ```
//!
//! All rows of a block have the same factor, so cones and directions stay as they are and bounds of intervals become `√w_c` times themselves.

use crate::instant::cone::laws::natural_map;
use crate::instant::cone::problem::{Law, Problem};
use nalgebra::{DMatrix, Vector3};

/// Blocks whose mobility is below this part of the largest do not move.
const IMMOBILE: f64 = 1e-24;

/// The problem.
pub(super) struct Scaled {
    /// D̂ (m × m).
    pub mobility: DMatrix<f64>,
    /// b̂ (m).
    pub free: Vec<f64>,
    /// The laws, with scaled bounds.
    pub laws: Vec<Law>,
    /// The first row of each block.
    pub starts: Vec<usize>,
    /// `1/√w_c` of each block.
    pub sizes: Vec<f64>,
}

impl Scaled {
    /// The scaled form of a problem.
    pub fn new(problem: &Problem) -> Self {
        let starts = problem.starts();
        let means: Vec<f64> = problem
            .laws
            .iter()
            .zip(&starts)
            .map(|(law, &start)| {
                let trace: f64 = (start..start + law.rows()).map(|row| problem.mobility[(row, row)]).sum();
                trace / law.rows() as f64
            })
            .collect();
        let largest = means.iter().fold(0.0_f64, |most, mean| most.max(*mean));
        let size = |mean: f64| match mean {
            _ if largest <= 0.0 => 1.0,
            mean if mean > IMMOBILE * largest => 1.0 / mean.sqrt(),
            _ => 1.0 / largest.sqrt(),
        };
        let sizes: Vec<f64> = means.into_iter().map(size).collect();
        let of_rows: Vec<f64> =
            problem.laws.iter().zip(&sizes).flat_map(|(law, &size)| std::iter::repeat_n(size, law.rows())).collect();
        let count = of_rows.len();
        let mobility = DMatrix::from_fn(count, count, |row, column| {
            problem.mobility[(row, column)] * of_rows[row] * of_rows[column]
        });
        let free = problem.free.iter().zip(&of_rows).map(|(free, size)| free * size).collect();
        let laws = problem.laws.iter().zip(&sizes).map(|(law, size)| match *law {
            Law::Interval { lower, upper } => Law::Interval { lower: lower / size, upper: upper / size },
            other => other,
        });
        Scaled { mobility, free, laws: laws.collect(), starts, sizes }
    }

    /// The same with a compliance in every block: `D̂ + κ`.
    pub fn softened(&self, compliance: f64) -> Self {
        let mut mobility = self.mobility.clone();
        for row in 0..self.free.len() {
            mobility[(row, row)] += compliance;
        }
        let (free, laws) = (self.free.clone(), self.laws.clone());
        Scaled { mobility, free, laws, starts: self.starts.clone(), sizes: self.sizes.clone() }
    }

    /// Blocks: first row and law.
    pub fn blocks(&self) -> impl Iterator<Item = (usize, Law)> + '_ {
        self.starts.iter().copied().zip(self.laws.iter().copied())
    }

    /// `û = D̂ r̂ + b̂`.
    pub fn rates(&self, forces: &[f64], rates: &mut [f64]) {
        rates.copy_from_slice(&self.free);
        for (column, &force) in forces.iter().enumerate().filter(|(_, force)| **force != 0.0) {
            self.add_column(column, force, rates);
        }
    }

    /// Adds `D̂ e_column · force` to rates.
    pub fn add_column(&self, column: usize, force: f64, rates: &mut [f64]) {
        for (rate, mobility) in rates.iter_mut().zip(self.mobility.column(column).iter()) {
            *rate += mobility * force;
        }
    }

    /// The sum of squares of the natural map: the measure that line searches reduce.
    pub fn merit(&self, forces: &[f64], rates: &[f64]) -> f64 {
        self.blocks().map(|(start, law)| natural_map(&law, &rates[start..], &forces[start..]).norm_squared()).sum()
    }

    /// The residual as [`crate::instant::cone::problem::Answer`] has it.
    pub fn residual(&self, forces: &[f64], rates: &[f64]) -> f64 {
        // Largest natural map and largest force, in forces and in scaled forces.
        let (mut worst, mut largest) = ([0.0_f64; 2], [0.0_f64; 2]);
        for ((start, law), size) in self.blocks().zip(&self.sizes) {
            let length = |values: &[f64]| block_of(&law, &values[start..]).norm();
            let off = natural_map(&law, &rates[start..], &forces[start..]).norm();
            let force = length(forces).max(length(&self.free));
            for (part, factor) in [*size, 1.0].into_iter().enumerate() {
                // A NaN must not pass for a small number.
                worst[part] = if off.is_finite() { worst[part].max(off * factor) } else { f64::INFINITY };
                largest[part] = largest[part].max(force * factor);
            }
        }
        let relative = |part: usize| if worst[part] > 0.0 { worst[part] / largest[part] } else { 0.0 };
        relative(0).max(relative(1))
    }

    /// The residual of forces that are not scaled.
    #[cfg(test)]
    pub fn residual_of(&self, forces: &[f64]) -> f64 {
        let forces = self.scale(forces);
        let mut rates = vec![0.0; forces.len()];
        self.rates(&forces, &mut rates);
        self.residual(&forces, &rates)
    }

    /// Scaled forces of forces.
    pub fn scale(&self, forces: &[f64]) -> Vec<f64> {
        self.by_rows(forces, |force, size| force / size)
    }

    /// Forces of scaled forces.
    pub fn unscale(&self, forces: &[f64]) -> Vec<f64> {
        self.by_rows(forces, |force, size| force * size)
    }

    fn by_rows(&self, values: &[f64], with: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let mut out = values.to_vec();
        for ((start, law), &size) in self.blocks().zip(&self.sizes) {
            for value in &mut out[start..start + law.rows()] {
                *value = with(*value, size);
            }
        }
        out
    }
}

/// The rows of a block as a vector, with zeros for rows that it does not have.
pub(super) fn block_of(law: &Law, values: &[f64]) -> Vector3<f64> {
    match law.rows() {
        1 => Vector3::new(values[0], 0.0, 0.0),
        _ => Vector3::new(values[0], values[1], values[2]),
    }
}

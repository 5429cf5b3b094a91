//! Semismooth Newton for all laws together, with a proximal term.
//!
//! ```text
//!     (A (D + ε) + B) δr = −F(u, r),     u = D r + b
//! ```
//!
//! `laws.rs` defines F, A and B (block diagonal). D is scaled, and ε is a compliance about the last iterate: it makes redundant contacts solvable and
//! changes the path, not the answer. Forces that the laws give at once (open contacts, intervals at a bound) are eliminated before the matrix is
//! formed. The step is halved until the natural map is smaller; the best iterate is kept.
//!
//! Source: P. Alart, A. Curnier 1991; semismooth Newton: L. Qi, J. Sun, A nonsmooth version of Newton's method, Mathematical Programming 58 (1993).

use crate::instant::cone::laws::{Equations, Form, equations};
use crate::instant::cone::scaled::Scaled;
use nalgebra::{DMatrix, DVector};

/// Most halvings of a step.
const HALVINGS: usize = 5;
/// The most steps in a row that gain less than a tenth, and the most of them if ε follows the map.
const PATIENCE: usize = 3;
const PATIENCE_SOFT: usize = 40;
/// The largest ε that follows the map.
const SOFTEST: f64 = 0.1;
/// Natural maps whose root mean square is below this part of the largest scaled force are rounding.
const ROUNDING: f64 = 1e-16;

/// How Newton's method goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settings {
    /// The equations of contacts.
    pub form: Form,
    /// ε; where it follows the map the least.
    pub compliance: f64,
    /// Whether ε follows the natural map: ε = |F| over the largest force, up to a tenth.
    pub follows: bool,
    /// Most iterations.
    pub iterations: usize,
}

/// Improves forces; they end at the best iterate.
pub(super) fn improve(problem: &Scaled, forces: &mut [f64], settings: Settings) {
    let count = forces.len();
    let mut rates = vec![0.0; count];
    problem.rates(forces, &mut rates);
    let mut best = forces.to_vec();
    let mut least = problem.merit(forces, &rates);
    let mut merit = least;
    let mut idle = 0;
    let (mut trial, mut trial_rates) = (vec![0.0; count], vec![0.0; count]);
    for _ in 0..settings.iterations {
        let largest = problem.free.iter().chain(forces.iter()).fold(0.0_f64, |most, value| most.max(value.abs()));
        if least <= (ROUNDING * largest).powi(2) * count as f64 {
            break;
        }
        let compliance = if settings.follows {
            (merit.sqrt() / largest).clamp(settings.compliance, SOFTEST)
        } else {
            settings.compliance
        };
        let Some(step) = step(problem, forces, &rates, Settings { compliance, ..settings }) else { break };
        let mut length = 1.0;
        let mut found = (f64::INFINITY, 1.0);
        for _ in 0..=HALVINGS {
            advance(problem, forces, &step, length, &mut trial, &mut trial_rates);
            let reached = problem.merit(&trial, &trial_rates);
            if reached < found.0 {
                found = (reached, length);
            }
            if reached < merit {
                break;
            }
            length *= 0.5;
        }
        if !found.0.is_finite() {
            break;
        }
        advance(problem, forces, &step, found.1, &mut trial, &mut trial_rates);
        forces.copy_from_slice(&trial);
        rates.copy_from_slice(&trial_rates);
        merit = found.0;
        // A tenth less of the map is a fifth less of its square.
        idle = if merit < 0.81 * least { 0 } else { idle + 1 };
        if merit < least {
            least = merit;
            best.copy_from_slice(forces);
        }
        if idle == if settings.follows { PATIENCE_SOFT } else { PATIENCE } {
            break;
        }
    }
    forces.copy_from_slice(&best);
}

/// Forces and rates after a part of a step.
fn advance(problem: &Scaled, forces: &[f64], step: &DVector<f64>, length: f64, to: &mut [f64], rates: &mut [f64]) {
    for ((to, from), change) in to.iter_mut().zip(forces).zip(step.iter()) {
        *to = from + length * change;
    }
    problem.rates(to, rates);
}

/// δr; `None` if the matrix is singular.
fn step(problem: &Scaled, forces: &[f64], rates: &[f64], settings: Settings) -> Option<DVector<f64>> {
    let count = forces.len();
    let mut step = DVector::zeros(count);
    let mut unknown = Vec::with_capacity(count);
    let mut local: Vec<(usize, usize, Equations)> = Vec::with_capacity(problem.laws.len());
    for (start, law) in problem.blocks() {
        let found = equations(&law, settings.form, &rates[start..], &forces[start..]);
        if found.by_rate.iter().all(|entry| *entry == 0.0) && found.by_force.lower_triangle() == found.by_force {
            // F does not depend on rates: B δr = −F, with B of ones on the diagonal.
            let change = found.by_force.solve_lower_triangular(&-found.value)?;
            for row in 0..law.rows() {
                step[start + row] = change[row];
            }
        } else {
            local.push((start, unknown.len(), found));
            unknown.extend(start..start + law.rows());
        }
    }
    if unknown.is_empty() {
        return Some(step);
    }
    // The changes of the rates by the known changes of forces.
    let mut known = vec![0.0; count];
    for (column, &change) in step.iter().enumerate().filter(|(_, change)| **change != 0.0) {
        problem.add_column(column, change, &mut known);
    }
    let size = unknown.len();
    let mut matrix = DMatrix::zeros(size, size);
    let mut right = DVector::zeros(size);
    for (place, &row) in unknown.iter().enumerate() {
        // Symmetric: the row as a column.
        let column = problem.mobility.column(row);
        for (out, &other) in matrix.column_mut(place).iter_mut().zip(&unknown) {
            *out = column[other];
        }
        matrix[(place, place)] += settings.compliance;
    }
    for (block, &(start, place, ref found)) in local.iter().enumerate() {
        let rows = local.get(block + 1).map_or(size, |next| next.1) - place;
        for column in 0..size {
            let mobility: [f64; 3] =
                std::array::from_fn(|row| if row < rows { matrix[(place + row, column)] } else { 0.0 });
            for row in 0..rows {
                matrix[(place + row, column)] =
                    (0..rows).map(|inner| found.by_rate[(row, inner)] * mobility[inner]).sum();
            }
        }
        for row in 0..rows {
            let moved: f64 = (0..rows).map(|inner| found.by_rate[(row, inner)] * known[start + inner]).sum();
            right[place + row] = -found.value[row] - moved;
            for inner in 0..rows {
                matrix[(place + row, place + inner)] += found.by_force[(row, inner)];
            }
        }
    }
    let solution = matrix.lu().solve(&right)?;
    for (&row, change) in unknown.iter().zip(solution.iter()) {
        step[row] = *change;
    }
    step.iter().all(|change| change.is_finite()).then_some(step)
}

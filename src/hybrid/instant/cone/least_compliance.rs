//! The forces that are reported where contacts are redundant: forces of equally stiff contacts in the limit of rigid ones.
//!
//! ```text
//!     minimise Σ w_c |r_c|²     over all r that fit the law with the same rates
//! ```
//!
//! It is the solution with the compliance κ w_c in every block, κ → 0: unique, continuous and without pinching. κ = 1e-6 leaves a relative error of
//! 1e-6 in the forces; plain Newton steps from there restore the law and keep the choice that the compliance has made.

use crate::instant::cone::cascade::EVERYDAY;
use crate::instant::cone::newton::{Settings, improve};
use crate::instant::cone::problem::{Answer, Problem};
use crate::instant::cone::scaled::Scaled;
use crate::instant::cone::settling::settle;

/// κ.
const COMPLIANCE: f64 = 1e-6;
/// Compliances on the way from zero.
const VANISHING: [f64; 3] = [1e-2, 1e-4, COMPLIANCE];
/// Newton iterations with a compliance.
const ITERATIONS: usize = 60;
/// Residuals up to this are solutions.
const ACCEPTED: f64 = 1e-10;
/// Rates that differ by less than this part of the largest belong to the same solution.
const SAME_RATES: f64 = 1e-8;

/// The forces of least compliance for an answer of a problem; the forces of the answer if they are not found.
pub(crate) fn least_compliance(problem: &Problem, answer: &Answer) -> Vec<f64> {
    let scaled = Scaled::new(problem);
    let near = scaled.scale(&answer.forces);
    let zero = vec![0.0; near.len()];
    let starts = [(near, &VANISHING[2..]), (zero.clone(), &VANISHING[2..]), (zero, &VANISHING[..])];
    let found =
        starts.into_iter().find_map(|(forces, compliances)| compliant(problem, &scaled, answer, forces, compliances));
    found.unwrap_or_else(|| answer.forces.clone())
}

/// The forces from a start; `None` if they miss the law or have other rates than the answer.
fn compliant(
    problem: &Problem,
    scaled: &Scaled,
    answer: &Answer,
    mut forces: Vec<f64>,
    compliances: &[f64],
) -> Option<Vec<f64>> {
    let mut rates = vec![0.0; forces.len()];
    let mut residual = f64::INFINITY;
    for &compliance in compliances {
        let soft = scaled.softened(compliance);
        improve(&soft, &mut forces, Settings { compliance: 0.0, iterations: ITERATIONS, ..EVERYDAY });
        soft.rates(&forces, &mut rates);
        residual = soft.residual(&forces, &rates);
    }
    if residual > ACCEPTED {
        return None;
    }
    improve(scaled, &mut forces, EVERYDAY);
    let found = settle(problem, scaled, &forces);
    let largest = problem.free.iter().chain(&answer.rates).fold(0.0_f64, |most, rate| most.max(rate.abs()));
    let same = found.rates.iter().zip(&answer.rates).all(|(one, other)| (one - other).abs() <= SAME_RATES * largest);
    (found.residual <= ACCEPTED && same).then_some(found.forces)
}

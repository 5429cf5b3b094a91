//! A step of a tree solved to rounding.
//!
//! Newton's method begins with the stages of the run, or on a cubic curve ([`crate::derivatives::forward::first_stages`]). A correction δv̄ of the velocities at the end counts as h δv̄: the matrix depends on them.

use crate::derivatives::forward::step::{Factors, ITERATIONS, KEPT, ROUNDING, SLOW, SQUARE, SolvedStep, StepProblem};
use crate::derivatives::forward::tree::family::Family;
use crate::derivatives::forward::tree::matrix::TreeMatrix;
use crate::derivatives::forward::tree::step::{TreeStep, efforts};
use nalgebra::DMatrix;

/// Solves a step of a tree, from the same step with another length if it is known, and the part of the length by which it differs; `None` if the
/// iteration does not converge.
pub(in crate::derivatives::forward) fn solve_tree(
    problem: &StepProblem,
    known: Option<(SolvedStep, f64)>,
) -> Option<SolvedStep> {
    let (s, h, free) = (problem.tableau.stages, problem.step, &problem.mode.free);
    let (n, all) = (free.len(), problem.start.velocity.len());
    let family = Family::new(&problem.figures.plain, free);
    let mut velocities = vec![0.0; all];
    for &freedom in free {
        let faster = problem.start.velocity[freedom] - problem.begun.velocity[freedom];
        velocities[freedom] = problem.toward.velocity[freedom] + faster;
    }
    let (mut stages, mut factors) = match known {
        Some((SolvedStep { stages, factors: Factors::Tree(factors), drift, .. }, change)) => {
            velocities.copy_from_slice(&stages.last()?.velocity);
            (stages, Some((factors, drift + change)))
        }
        _ => (problem.first_stages(), None),
    };
    let made = |step: &TreeStep| Some(Box::new(TreeMatrix::new(step).factors()?));
    let mut last = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let step = TreeStep::new(problem, &family, &stages, &velocities);
        let (own, drift) = match factors.take() {
            Some(kept) => kept,
            None => (made(&step)?, 0.0),
        };
        let residual = step.residual(&efforts(&step));
        let correction = own.solve(&DMatrix::from_column_slice(residual.len(), 1, residual.as_slice()));
        let [displaced, faster] =
            [(0, s - 1), (s - 1, 1)].map(|(stage, many)| correction.rows(stage * n, many * n).amax());
        let size = displaced.max(h.abs() * faster);
        if !size.is_finite() {
            return None;
        }
        let mut moved = vec![0.0; all];
        for (index, stage) in stages.iter_mut().enumerate() {
            free.iter().enumerate().for_each(|(row, &freedom)| moved[freedom] = -correction[(index * n + row, 0)]);
            stage.displace(problem.mechanism, &moved);
        }
        free.iter().enumerate().for_each(|(row, &freedom)| velocities[freedom] -= correction[((s - 1) * n + row, 0)]);
        let drift = drift + size;
        if size < ROUNDING && (size >= 0.25 * last || size * drift <= SQUARE) {
            let (factors, drift) = match drift <= KEPT {
                true => (own, drift),
                false => (made(&TreeStep::new(problem, &family, &stages, &velocities))?, 0.0),
            };
            let end = stages.last_mut()?;
            end.velocity = velocities;
            end.time = problem.start.time + h;
            let multipliers = vec![Vec::new(); s];
            return Some(SolvedStep { stages, multipliers, factors: Factors::Tree(factors), drift });
        }
        if size <= SLOW * last {
            factors = Some((own, drift));
        }
        last = size;
    }
    None
}

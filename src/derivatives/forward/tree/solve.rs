//! A step of a tree solved to rounding.
//!
//! Newton's method begins with stages on the cubic curve through both ends of the step of the run:
//!
//! ```text
//!     y(c) = h v₀ c + (3Δ − 2 h v₀ − h v₁) c² + (h v₀ + h v₁ − 2Δ) c³        Δ = y₁ − y₀
//! ```

use crate::derivatives::forward::between::motion_between;
use crate::derivatives::forward::step::{Factors, ITERATIONS, ROUNDING, SLOW, SolvedStep, StepProblem};
use crate::derivatives::forward::tree::family::Family;
use crate::derivatives::forward::tree::matrix::TreeMatrix;
use crate::derivatives::forward::tree::step::{TreeStep, efforts};
use crate::derivatives::forward::tree_factors::TreeFactors;
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;

/// Solves a step of a tree; `None` if the iteration does not converge.
pub(in crate::derivatives::forward) fn solve_tree(problem: &StepProblem) -> Option<SolvedStep> {
    let (s, h, free) = (problem.tableau.stages, problem.step, &problem.mode.free);
    let (n, all) = (free.len(), problem.start.velocity.len());
    let family = Family::new(&problem.figures.plain, free);
    let mut velocities = vec![0.0; all];
    free.iter().for_each(|&freedom| velocities[freedom] = problem.toward.velocity[freedom]);
    let mut stages = first_stages(problem);
    let mut factors: Option<TreeFactors> = None;
    let mut last = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let step = TreeStep::new(problem, &family, &stages, &velocities);
        let own = match factors.take() {
            Some(kept) => kept,
            None => TreeMatrix::new(&step).factors()?,
        };
        let residual = step.residual(&efforts(&step));
        let correction = own.solve(&DMatrix::from_column_slice(residual.len(), 1, residual.as_slice()))?;
        let size = correction.rows(0, (s - 1) * n).amax();
        if !size.is_finite() {
            return None;
        }
        for (index, stage) in stages.iter_mut().enumerate() {
            let mut moved = vec![0.0; all];
            free.iter().enumerate().for_each(|(row, &freedom)| moved[freedom] = -correction[(index * n + row, 0)]);
            stage.displace(problem.mechanism, &moved);
        }
        free.iter().enumerate().for_each(|(row, &freedom)| velocities[freedom] -= correction[((s - 1) * n + row, 0)]);
        if size < ROUNDING && size >= 0.25 * last || size == 0.0 {
            let step = TreeStep::new(problem, &family, &stages, &velocities);
            let factors = Box::new(TreeMatrix::new(&step).factors()?);
            let end = stages.last_mut()?;
            end.velocity = velocities;
            end.time = problem.start.time + h;
            return Some(SolvedStep { stages, multipliers: vec![Vec::new(); s], factors: Factors::Tree(factors) });
        }
        if size <= SLOW * last {
            factors = Some(own);
        }
        last = size;
    }
    None
}

/// Stages i = 2..s on a cubic curve through both ends.
fn first_stages(problem: &StepProblem) -> Vec<State> {
    let (tableau, h, start) = (problem.tableau, problem.step, problem.start);
    let whole = motion_between(problem.mechanism, start, problem.toward);
    let is_near = problem.toward.time > start.time;
    let mut free = vec![false; start.velocity.len()];
    problem.mode.free.iter().for_each(|&freedom| free[freedom] = true);
    let at = |i: usize| {
        let c = tableau.nodes[i];
        let along = |freedom: usize| {
            let first = h * start.velocity[freedom];
            if !free[freedom] {
                return 0.0;
            }
            if !is_near {
                return c * first;
            }
            let (all, last) = (whole[freedom], h * problem.toward.velocity[freedom]);
            c * (first + c * (3.0 * all - 2.0 * first - last + c * (first + last - 2.0 * all)))
        };
        let moved: Vec<f64> = (0..free.len()).map(along).collect();
        let mut stage = start.clone();
        stage.displace(problem.mechanism, &moved);
        stage.time = start.time + h * c;
        stage
    };
    (1..tableau.stages).map(at).collect()
}

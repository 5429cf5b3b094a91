//! A step of a tree solved to rounding, and its derivatives.
//!
//! Newton's method begins with stages on the cubic curve through both ends of the step of the run:
//!
//! ```text
//!     y(c) = h v₀ c + (3Δ − 2 h v₀ − h v₁) c² + (h v₀ + h v₁ − 2Δ) c³        Δ = y₁ − y₀
//! ```

use crate::derivatives::forward::between::motion_between;
use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::step::{Factors, ITERATIONS, ROUNDING, SLOW, SolvedStep, StepProblem};
use crate::derivatives::forward::tangent::{Tangent, carried};
use crate::derivatives::forward::tree::adjoint::{Cotangents, FigureCotangents};
use crate::derivatives::forward::tree::column::Column;
use crate::derivatives::forward::tree::family::Family;
use crate::derivatives::forward::tree::matrix::TreeMatrix;
use crate::derivatives::forward::tree::step::{TreeStep, efforts};
use crate::derivatives::forward::tree_factors::TreeFactors;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

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

/// The derivatives of a loss, taken back over a step.
pub(in crate::derivatives) struct PulledBack {
    /// By what is given in the step.
    pub given: Cotangents,
    /// By each parameter that changes springs, dampers, motors, loads or rotors.
    pub laws: Vec<f64>,
}

/// Goes back over a solved step of a tree, from derivatives by q̄ and v̄ (n each); those by figures are added.
pub(in crate::derivatives) fn pulled_back(
    problem: &StepProblem,
    solved: &SolvedStep,
    factors: &TreeFactors,
    of_end: [&DVector<f64>; 2],
    figures: &mut FigureCotangents,
    slopes: &[Option<FigureSlopes>],
) -> Option<PulledBack> {
    let free = &problem.mode.free;
    let family = Family::new(&problem.figures.plain, free);
    let step = TreeStep::new(problem, &family, &solved.stages, &solved.stages.last()?.velocity);
    let [positions, velocities] = of_end.map(|of| of.select_rows(free));
    let weights = factors.solve_transposed(&positions, &velocities)?;
    let mut given = step.pull_back(&efforts(&step), &weights, figures);
    let end = solved.stages.last()?;
    let back = carried(problem.mechanism, end, problem.start, of_end[0]);
    for freedom in 0..back.len() {
        given.positions[freedom] += back[freedom];
        given.velocities[freedom] += of_end[1][freedom];
        step.pull_gone(freedom, of_end[0][freedom], &mut given);
    }
    let law = |slopes: &Option<FigureSlopes>| {
        let slopes = slopes.as_ref().filter(|slopes| slopes.changes_laws());
        slopes.map_or(0.0, |slopes| -weights.dot(&step.law_changes(slopes)))
    };
    Some(PulledBack { given, laws: slopes.iter().map(law).collect() })
}

/// The derivatives that go over a step of a tree.
pub(in crate::derivatives::forward) struct TreeColumns<'c> {
    pub tangent: &'c Tangent,
    /// δh (p).
    pub longer: &'c DVector<f64>,
    /// Of the efforts at all stages by the parameters (n × p each), and by time (n each).
    pub efforts: &'c [DMatrix<f64>],
    pub rates: &'c [DVector<f64>],
}

impl TreeColumns<'_> {
    /// ∂q̄/∂θ and ∂v̄/∂θ of the freedoms that move.
    pub fn carried(
        &self,
        problem: &StepProblem,
        solved: &SolvedStep,
        factors: &TreeFactors,
        slopes: &[Option<FigureSlopes>],
    ) -> Option<[DMatrix<f64>; 2]> {
        let (s, n) = (problem.tableau.stages, problem.mode.free.len());
        let family = Family::new(&problem.figures.plain, &problem.mode.free);
        let end = solved.stages.last()?;
        let step = TreeStep::new(problem, &family, &solved.stages, &end.velocity);
        let Tangent { positions, velocities, times } = self.tangent;
        let all = positions.nrows();
        let effort = |column: usize, stage: usize, freedom: usize| {
            let later = times[column] + problem.tableau.nodes[stage] * self.longer[column];
            self.efforts[stage][(freedom, column)] + self.rates[stage][freedom] * later
        };
        let given: Vec<_> =
            (0..positions.ncols()).map(|column| move |stage, freedom| effort(column, stage, freedom)).collect();
        let of = |(column, effort): (usize, _)| Column {
            positions: &positions.as_slice()[column * all..][..all],
            velocities: &velocities.as_slice()[column * all..][..all],
            longer: self.longer[column],
            efforts: effort,
            figures: slopes.get(column).and_then(Option::as_ref),
        };
        let columns: Vec<Column> =
            given.iter().map(|given| given as &dyn Fn(usize, usize) -> f64).enumerate().map(of).collect();
        let found = factors.solve(&step.right(&efforts(&step), &columns))?;
        let [mut ends, mut rates] = [s - 2, s - 1].map(|index| found.rows(index * n, n).into_owned());
        for column in 0..positions.ncols() {
            let moved = carried(problem.mechanism, problem.start, end, &positions.column(column).into_owned());
            for (row, &freedom) in problem.mode.free.iter().enumerate() {
                let gone = problem.step * velocities[(freedom, column)];
                let longer = self.longer[column] * problem.start.velocity[freedom];
                ends[(row, column)] += moved[freedom] + (gone + longer);
                rates[(row, column)] += velocities[(freedom, column)];
            }
        }
        Some([ends, rates])
    }
}

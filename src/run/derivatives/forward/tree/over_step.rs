//! Steps and derivatives over them: by the equations of trees if these are all, otherwise by the equations of all mechanisms.

use crate::derivatives::forward::step::{Factors, SolvedStep, StepProblem};
use crate::derivatives::forward::tangent::{InputSlopes, Tangent, Varied, by_length_whole, carried};
use crate::derivatives::forward::tree::carrying::TreeColumns;
use crate::derivatives::forward::tree::solve::solve_tree;
use crate::derivatives::forward::tree::step::is_tree;
use nalgebra::{DMatrix, DVector};

impl StepProblem<'_> {
    /// Solves it, from the same step with another length if that is known, and the part of the length by which it differs; `None` if the iteration
    /// does not converge.
    pub fn solve(&self, known: Option<(SolvedStep, f64)>) -> Option<SolvedStep> {
        if self.is_tree() { solve_tree(self, known) } else { self.solve_whole(known) }
    }

    /// Whether it has the equations of a tree alone.
    pub fn is_tree(&self) -> bool {
        is_tree(&self.figures.plain) && self.mode.row_count == 0
    }
}

impl Tangent {
    /// Goes on over a solved step whose length varies by δh (p); the time at the end varies by δt₀ + δh.
    pub fn carry(
        &mut self,
        problem: &StepProblem,
        solved: &SolvedStep,
        varied: &Varied,
        slopes: &InputSlopes,
        longer: &DVector<f64>,
    ) -> Option<()> {
        if self.times.is_empty() {
            return Some(());
        }
        let Factors::Tree(factors) = &solved.factors else {
            return self.carry_whole(problem, solved, varied, slopes, longer);
        };
        let StepProblem { mechanism, start, mode, .. } = problem;
        let end = solved.stages.last()?;
        let columns = TreeColumns { tangent: self, longer, efforts: slopes.efforts, rates: slopes.rates };
        let [positions, velocities] = columns.carried(problem, solved, factors, varied.slopes())?;
        for column in 0..self.positions.ncols() {
            let mut moved = carried(mechanism, start, end, &self.positions.column(column).into_owned());
            self.velocities.column_mut(column).fill(0.0);
            for (row, &freedom) in mode.free.iter().enumerate() {
                moved[freedom] = positions[(row, column)];
                self.velocities[(freedom, column)] = velocities[(row, column)];
            }
            self.positions.set_column(column, &moved);
        }
        self.times += longer;
        Some(())
    }
}

/// ∂q̄/∂h and ∂v̄/∂h of a solved step (n each), for efforts that change at these rates at its stages; `None` if the factors are singular.
pub fn by_length(
    problem: &StepProblem,
    solved: &SolvedStep,
    rates: &[DVector<f64>],
) -> Option<(DVector<f64>, DVector<f64>)> {
    let Factors::Tree(factors) = &solved.factors else { return by_length_whole(problem, solved, rates) };
    let (n, stages) = (problem.start.velocity.len(), problem.tableau.stages);
    let tangent =
        Tangent { positions: DMatrix::zeros(n, 1), velocities: DMatrix::zeros(n, 1), times: DVector::zeros(1) };
    let (longer, still) = (DVector::from_element(1, 1.0), vec![DMatrix::zeros(n, 1); stages]);
    let columns = TreeColumns { tangent: &tangent, longer: &longer, efforts: &still, rates };
    let [positions, velocities] = columns.carried(problem, solved, factors, &[None])?;
    let spread = |of: &DMatrix<f64>| {
        let mut all = DVector::zeros(n);
        problem.mode.free.iter().enumerate().for_each(|(row, &freedom)| all[freedom] = of[(row, 0)]);
        all
    };
    Some((spread(&positions), spread(&velocities)))
}

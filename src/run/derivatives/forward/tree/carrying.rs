//! Derivatives over a solved step of a tree: forward by columns or by rows, and against time.
//!
//! ```text
//!     column of a parameter    R_u δu = −R_x δx − R_θ δθ
//!     row of a freedom         R_uᵀ μ = e_r        δx̄_r = Φ_r δx + Θ_r δθ        for all parameters at once
//! ```
//!
//! There are 2n rows: more parameters than these are cheaper by rows.

use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::step::{SolvedStep, StepProblem};
use crate::derivatives::forward::tangent::{Tangent, carried};
use crate::derivatives::forward::tree::adjoint::{Cotangents, FigureCotangents};
use crate::derivatives::forward::tree::column::Column;
use crate::derivatives::forward::tree::course::FreedomCourse;
use crate::derivatives::forward::tree::family::Family;
use crate::derivatives::forward::tree::step::{TreeStep, efforts};
use crate::derivatives::forward::tree_factors::TreeFactors;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// A solved step, to go back over.
struct Backwards<'b> {
    step: TreeStep<'b>,
    courses: Vec<FreedomCourse>,
    efforts: Vec<Vec<f64>>,
    end: &'b State,
    factors: &'b TreeFactors,
}

impl<'b> Backwards<'b> {
    fn new(
        problem: &'b StepProblem<'b>,
        family: &'b Family,
        solved: &'b SolvedStep,
        factors: &'b TreeFactors,
    ) -> Option<Self> {
        let end = solved.stages.last()?;
        let step = TreeStep::new(problem, family, &solved.stages, &end.velocity);
        let (courses, efforts) = (step.courses(), efforts(&step));
        Some(Backwards { step, courses, efforts, end, factors })
    }

    /// The cotangents of all that is given, from those of q̄ and v̄ (n each), and the weights μ; the cotangents of figures are added.
    fn pulled(&self, of_end: [&DVector<f64>; 2], figures: &mut FigureCotangents) -> Option<(Cotangents, DVector<f64>)> {
        let problem = self.step.problem;
        let [positions, velocities] = of_end.map(|of| of.select_rows(&problem.mode.free));
        let weights = self.factors.solve_transposed(&positions, &velocities);
        let mut given = self.step.pull_back(&self.courses, &self.efforts, &weights, figures);
        let back = carried(problem.mechanism, self.end, problem.start, of_end[0]);
        for freedom in 0..back.len() {
            given.positions[freedom] += back[freedom];
            given.velocities[freedom] += of_end[1][freedom];
            self.step.pull_gone(freedom, of_end[0][freedom], &mut given);
        }
        Some((given, weights))
    }

    /// δR of springs, dampers, motors, loads and rotors by each parameter, if it changes any.
    fn laws(&self, slopes: &[Option<FigureSlopes>]) -> Vec<Option<DVector<f64>>> {
        let of = |slopes: &Option<FigureSlopes>| {
            let slopes = slopes.as_ref().filter(|slopes| slopes.changes_laws());
            slopes.map(|slopes| self.step.law_changes(slopes))
        };
        slopes.iter().map(of).collect()
    }
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
    let family = Family::new(&problem.figures.plain, &problem.mode.free);
    let back = Backwards::new(problem, &family, solved, factors)?;
    let (given, weights) = back.pulled(of_end, figures)?;
    let changes = back.laws(slopes);
    let laws = changes.iter().map(|change| change.as_ref().map_or(0.0, |change| -weights.dot(change)));
    Some(PulledBack { given, laws: laws.collect() })
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
        let many = self.tangent.positions.ncols() > 2 * problem.mode.free.len();
        if many {
            self.by_rows(problem, solved, factors, slopes)
        } else {
            self.by_columns(problem, solved, factors, slopes)
        }
    }

    /// A solve for each parameter.
    pub(super) fn by_columns(
        &self,
        problem: &StepProblem,
        solved: &SolvedStep,
        factors: &TreeFactors,
        slopes: &[Option<FigureSlopes>],
    ) -> Option<[DMatrix<f64>; 2]> {
        let (s, n) = (problem.tableau.stages, problem.mode.free.len());
        let end = solved.stages.last()?;
        let family = Family::new(&problem.figures.plain, &problem.mode.free);
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
        let found = factors.solve(&step.right(&efforts(&step), &columns));
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

    /// A transposed solve for each freedom.
    pub(super) fn by_rows(
        &self,
        problem: &StepProblem,
        solved: &SolvedStep,
        factors: &TreeFactors,
        slopes: &[Option<FigureSlopes>],
    ) -> Option<[DMatrix<f64>; 2]> {
        let family = Family::new(&problem.figures.plain, &problem.mode.free);
        let back = Backwards::new(problem, &family, solved, factors)?;
        let Tangent { positions, velocities, times } = self.tangent;
        let ((n, p), free) = (positions.shape(), problem.mode.free.len());
        let mut of_start = [DMatrix::zeros(2 * free, n), DMatrix::zeros(2 * free, n)];
        let mut of_efforts: Vec<DMatrix<f64>> = vec![DMatrix::zeros(2 * free, n); self.efforts.len()];
        let mut found = DMatrix::zeros(2 * free, p);
        let laws = back.laws(slopes);
        let still = DVector::zeros(n);
        for row in 0..2 * free {
            let mut unit = still.clone();
            unit[problem.mode.free[row % free]] = 1.0;
            let of_end = if row < free { [&unit, &still] } else { [&still, &unit] };
            let mut figures = FigureCotangents::zero(problem.figures.plain.bodies.len(), slopes);
            let (given, weights) = back.pulled(of_end, &mut figures)?;
            for (to, own) in of_start.iter_mut().zip([&given.positions, &given.velocities]) {
                to.row_mut(row).iter_mut().zip(own).for_each(|(to, own)| *to = *own);
            }
            for (to, own) in of_efforts.iter_mut().zip(&given.efforts) {
                to.row_mut(row).iter_mut().zip(own).for_each(|(to, own)| *to = *own);
            }
            for column in 0..p {
                let own = slopes.get(column).and_then(Option::as_ref).map_or(0.0, |slopes| figures.by(slopes));
                let law = laws.get(column).and_then(Option::as_ref).map_or(0.0, |change| -weights.dot(change));
                found[(row, column)] = own + law + given.longer * self.longer[column];
            }
        }
        found.gemm(1.0, &of_start[0], positions, 1.0);
        found.gemm(1.0, &of_start[1], velocities, 1.0);
        for (stage, of_efforts) in of_efforts.iter().enumerate() {
            if self.efforts[stage].iter().any(|slope| *slope != 0.0) {
                found.gemm(1.0, of_efforts, &self.efforts[stage], 1.0);
            }
            if self.rates[stage].iter().any(|rate| *rate != 0.0) {
                let later = times + self.longer * problem.tableau.nodes[stage];
                found += (of_efforts * &self.rates[stage]) * later.transpose();
            }
        }
        Some([found.rows(0, free).into_owned(), found.rows(free, free).into_owned()])
    }
}

//! One step of the scheme solved to rounding, with the factors of its exact derivatives.
//!
//! Newton's method on [`crate::derivatives::forward::stage_equations`] begins with the stages of the run, and with the multipliers that balance them.
//! Its matrix comes from dual numbers, or from blocks ([`crate::derivatives::forward::tree`]), and is kept while it shrinks the residuals fast. The matrix at the solution is the one of the implicit function theorem:
//!
//! ```text
//!     R(u; x) = 0        R_u δu = −R_x δx
//! ```
//!
//! Trees have their equations written out ([`crate::derivatives::forward::tree`]); these here are for all mechanisms.

use crate::derivatives::equations::closed::ClosedContacts;
use crate::derivatives::equations::figures::{End, Figures, Frame, LoopFigures};
use crate::derivatives::equations::laws::Laws;
use crate::derivatives::forward::elimination::Elimination;
use crate::derivatives::forward::stage_equations::{BothFigures, Drive, InMode, Residual, StepMotion};
use crate::derivatives::forward::tree_factors::TreeFactors;
use crate::derivatives::numbers::dual::Dual;
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::instant::holding::elements::Elements;
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::closure::Coordinate;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector, Vector3};
use std::ops::Range;

/// Derivatives that are computed at once.
pub const WIDTH: usize = 8;
/// Numbers with derivatives.
pub type Part = Dual<WIDTH>;

/// Iterations; about six are made.
pub(super) const ITERATIONS: usize = 60;
/// The matrix is renewed if a correction is larger than this part of the one before.
pub(super) const SLOW: f64 = 0.1;
/// Corrections this small (rad or m) that do not shrink any more are rounding.
pub(super) const ROUNDING: f64 = 1e-10;
/// Newton's method is at its end if the next correction, the last one times the drift of the matrix, is smaller than this (rad² or m²).
pub(super) const SQUARE: f64 = 1e-19;
/// Factors with less drift belong to the solution: derivatives are off by up to a hundred times as large a part.
pub(super) const KEPT: f64 = 1e-14;
/// Multipliers have fewer digits than displacements, and less part in the matrix: a part of theirs counts by this part.
const SMALLER: f64 = 1e-3;
/// Singular values of the directions of multipliers below this are zero (m, or N m s² of unit forces).
const MULTIPLIED: f64 = 1e-14;

/// A step that is solved.
pub struct SolvedStep {
    /// The stages i = 2..s; the last one is the end, with its velocities and time.
    pub stages: Vec<State>,
    /// Λ_1 … Λ_s (an entry for each closure).
    pub multipliers: Vec<Vec<f64>>,
    /// R_u, factored.
    pub factors: Factors,
    /// How far the stages have moved since then: a part of the step, or a displacement (rad or m).
    pub drift: f64,
}

/// A factored matrix R_u.
pub enum Factors {
    /// Of all unknowns.
    Whole(Elimination),
    /// Of a tree.
    Tree(Box<TreeFactors>),
}

impl Factors {
    /// R_u⁻¹ times a matrix.
    pub fn solve(&self, right: &DMatrix<f64>) -> DMatrix<f64> {
        match self {
            Factors::Whole(factors) => factors.solve_all(right),
            Factors::Tree(factors) => factors.solve(right),
        }
    }
}

/// The mode in which a step is made.
#[derive(Clone, Debug, Default)]
pub struct StepMode {
    /// The degrees of freedom that move.
    pub free: Vec<usize>,
    /// Independent closures, and the number of all.
    pub rows: Vec<usize>,
    pub row_count: usize,
    /// The motors that follow their laws, by number.
    pub motors: Vec<(usize, Coordinate)>,
    /// Contacts that are closed, and the same as constants with derivatives.
    pub closed: ClosedContacts<f64>,
    pub constant: ClosedContacts<Part>,
    /// For each closed contact the direction of its slip at the start, or the one in which it begins to slide.
    pub slips: Vec<Vector3<f64>>,
}

impl StepMode {
    /// The motors as forces.
    pub fn drives<T: Number>(&self, laws: &Laws<T>) -> Vec<Drive<T>> {
        let drive = |&(motor, coordinate): &(usize, Coordinate)| {
            let law = &laws.motors[motor];
            Drive { coordinate, kp: law.kp, kd: law.kd }
        };
        self.motors.iter().map(drive).collect()
    }

    /// The rows of the equations and unknowns of a step with this number of stages.
    pub fn size(&self, stages: usize) -> usize {
        stages * (self.free.len() + self.rows.len())
    }

    /// The residuals as one vector, without those of held joints and of dependent closures.
    pub fn select<T: Number>(&self, residual: &Residual<T>, freedoms: usize) -> Vec<T> {
        let mut rows = Vec::new();
        for motion in residual.motion.chunks(freedoms.max(1)) {
            rows.extend(self.free.iter().map(|&freedom| motion[freedom]));
        }
        for stage in residual.closures.iter().chain([&residual.rates]) {
            rows.extend(self.rows.iter().map(|&row| stage[row]));
        }
        rows
    }
}

/// A step that is to be solved.
pub struct StepProblem<'p> {
    pub mechanism: &'p Mechanism,
    pub figures: &'p BothFigures<f64>,
    /// The same as constants with derivatives.
    pub constant: &'p BothFigures<Part>,
    pub tableau: &'p Tableau,
    pub mode: &'p StepMode,
    pub start: &'p State,
    /// h (s).
    pub step: f64,
    /// The same step from a state nearby: its start, its end, and its inner stages, if they are known.
    pub begun: &'p State,
    pub toward: &'p State,
    pub inside: &'p [State],
    /// Efforts from outside at all stages (n each).
    pub efforts: &'p [DVector<f64>],
}

impl<T: Number> BothFigures<T> {
    /// The figures of a mechanism with frames on its bodies, each number as `take` makes it of the double.
    pub(crate) fn taken(
        mechanism: &Mechanism,
        elements: &Elements,
        frames: &[Pose],
        take: impl Fn(usize, f64) -> T,
    ) -> Self {
        let mut count = 0..;
        let moving = Figures::taken(mechanism, frames, &mut |value| {
            let value = take(count.next().unwrap_or_default(), value);
            Jet { value, rate: T::zero(), acceleration: T::zero() }
        });
        let mut count = 0..;
        let mut take = |value| take(count.next().unwrap_or_default(), value);
        let plain = Figures::taken(mechanism, frames, &mut take);
        let laws = Laws::taken(mechanism, elements, frames, &mut take);
        BothFigures { plain, moving, laws }
    }
}

/// A constant as a number with derivatives.
pub fn constant<T: Number>(values: &[f64]) -> Vec<T> {
    values.iter().map(|&value| T::of(value)).collect()
}

impl StepProblem<'_> {
    /// The factor of forces and efforts in a stage: h², or h b_s.
    pub(super) fn factor(&self, stage: usize) -> f64 {
        let (h, tableau) = (self.step, self.tableau);
        if stage + 1 < tableau.stages { h * h } else { h * tableau.weights[stage] }
    }

    /// Solves it by the equations of all mechanisms; `None` if the iteration does not converge.
    pub(super) fn solve_whole(&self, known: Option<(SolvedStep, f64)>) -> Option<SolvedStep> {
        let (s, StepMode { free, rows, .. }) = (self.tableau.stages, self.mode);
        let (n, m) = (free.len(), rows.len());
        let all = self.start.velocity.len();
        let spread = |moved: &[f64]| {
            let mut whole = vec![0.0; all];
            free.iter().zip(moved).for_each(|(&freedom, &by)| whole[freedom] = by);
            whole
        };
        let mut of_multipliers = None;
        let (mut stages, mut velocities, mut multipliers, mut factors) = match known {
            Some((SolvedStep { stages, multipliers, factors: Factors::Whole(factors), drift }, change)) => {
                let velocities = stages.last()?.velocity.clone();
                (stages, velocities, multipliers, Some((factors, drift + change)))
            }
            _ => {
                let stages = self.first_stages();
                let faster = |&freedom: &usize| self.start.velocity[freedom] - self.begun.velocity[freedom];
                let ended: Vec<f64> =
                    free.iter().map(|freedom| self.toward.velocity[*freedom] + faster(freedom)).collect();
                let velocities = spread(&ended);
                let (multipliers, columns) = self.first_multipliers(&stages, &velocities);
                of_multipliers = columns;
                (stages, velocities, multipliers, None)
            }
        };
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let (matrix, drift) = match factors.take() {
                Some(kept) => kept,
                None => (self.factors(&stages, &velocities, &multipliers, of_multipliers.take())?, 0.0),
            };
            let residual = self.residual(&stages, &velocities, &multipliers);
            let correction = DVector::from_vec(matrix.solve(residual.as_slice()));
            let size = if n > 0 { correction.rows(0, (s - 1) * n).amax() } else { 0.0 };
            if !size.is_finite() {
                return None;
            }
            for (index, stage) in stages.iter_mut().enumerate() {
                let moved: Vec<f64> = correction.rows(index * n, n).iter().map(|part| -part).collect();
                stage.displace(self.mechanism, &spread(&moved));
            }
            let faster = correction.rows((s - 1) * n, n);
            free.iter().zip(faster.iter()).for_each(|(&freedom, part)| velocities[freedom] -= part);
            let most = multipliers.iter().flatten().fold(f64::MIN_POSITIVE, |most: f64, push| most.max(push.abs()));
            for (stage, multipliers) in multipliers.iter_mut().enumerate() {
                let pushed = correction.rows(s * n + stage * m, m);
                rows.iter().zip(pushed.iter()).for_each(|(&row, part)| multipliers[row] -= part);
            }
            // Multipliers have the roundings of forces over h².
            let pushed = if m > 0 { correction.rows(s * n, s * m).amax() / most } else { 0.0 };
            let drift = drift + size + SMALLER * pushed;
            if size < ROUNDING && (size >= 0.25 * last || size * drift <= SQUARE) || size == 0.0 {
                let (factors, drift) = match drift <= KEPT {
                    true => (matrix, drift),
                    false => (self.factors(&stages, &velocities, &multipliers, None)?, 0.0),
                };
                let end = stages.last_mut()?;
                end.velocity = velocities;
                end.time = self.start.time + self.step;
                return Some(SolvedStep { stages, multipliers, factors: Factors::Whole(factors), drift });
            }
            if size <= SLOW * last {
                factors = Some((matrix, drift));
            }
            last = size;
        }
        None
    }

    /// Multipliers that balance the forces at some stages best, and solve the equations if these are its stages: equations are linear in them. And
    /// the columns of multipliers in R_u, if they were found whole.
    fn first_multipliers(&self, stages: &[State], velocities: &[f64]) -> (Vec<Vec<f64>>, Option<DMatrix<f64>>) {
        let StepMode { free, rows, row_count, .. } = self.mode;
        let (s, n, m) = (self.tableau.stages, free.len(), rows.len());
        let mut multipliers = vec![vec![0.0; *row_count]; s];
        if m == 0 || n == 0 {
            return (multipliers, None);
        }
        let off = -self.residual(stages, velocities, &multipliers).rows(0, s * n);
        let (columns, whole) = match self.is_looped() {
            true => (self.push_columns(stages), None),
            false => {
                let mut whole = DMatrix::zeros(self.mode.size(s), s * m);
                self.fill(stages, velocities, &multipliers, s * n..s * (n + m), &mut whole);
                (whole.rows(0, s * n).into_owned(), Some(whole))
            }
        };
        let found = columns.svd(true, true).solve(&off, MULTIPLIED).ok();
        for (index, push) in found.iter().flat_map(|found| found.iter()).enumerate() {
            multipliers[index / m][rows[index % m]] = *push;
        }
        (multipliers, whole)
    }

    pub(super) fn residual(&self, stages: &[State], velocities: &[f64], multipliers: &[Vec<f64>]) -> DVector<f64> {
        let n = velocities.len();
        let efforts: Vec<Vec<f64>> = self.efforts.iter().map(|efforts| efforts.iter().copied().collect()).collect();
        let drives = self.mode.drives(&self.figures.laws);
        let motion = StepMotion {
            figures: self.figures,
            tableau: self.tableau,
            step: self.step,
            start: self.start,
            start_offsets: &vec![0.0; n],
            start_velocities: &self.start.velocity,
            stages,
            offsets: &vec![vec![0.0; n]; stages.len()],
            end_velocities: velocities,
            efforts: &efforts,
            mode: InMode { drives: &drives, closed: &self.mode.closed, multipliers },
        };
        DVector::from_vec(self.mode.select(&motion.residual(), n))
    }

    /// R_u at some stages, factored; `None` if it is singular. `of_multipliers` are its last columns, if they are known.
    fn factors(
        &self,
        stages: &[State],
        velocities: &[f64],
        multipliers: &[Vec<f64>],
        of_multipliers: Option<DMatrix<f64>>,
    ) -> Option<Elimination> {
        let matrix = match of_multipliers {
            _ if self.is_looped() => self.looped_matrix(stages, velocities, multipliers),
            None => self.matrix(stages, velocities, multipliers),
            Some(known) => {
                let count = self.mode.size(self.tableau.stages);
                let first = count - known.ncols();
                let mut matrix = DMatrix::zeros(count, count);
                self.fill(stages, velocities, multipliers, 0..first, &mut matrix);
                matrix.columns_mut(first, known.ncols()).copy_from(&known);
                matrix
            }
        };
        Elimination::new(&matrix)
    }

    /// R_u at some stages, for all mechanisms.
    pub(super) fn matrix(&self, stages: &[State], velocities: &[f64], multipliers: &[Vec<f64>]) -> DMatrix<f64> {
        let count = self.mode.size(self.tableau.stages);
        let mut matrix = DMatrix::zeros(count, count);
        self.fill(stages, velocities, multipliers, 0..count, &mut matrix);
        matrix
    }

    /// Fills the columns of R_u by some unknowns.
    fn fill(
        &self,
        stages: &[State],
        velocities: &[f64],
        multipliers: &[Vec<f64>],
        unknowns: Range<usize>,
        matrix: &mut DMatrix<f64>,
    ) {
        let StepMode { free, rows, .. } = self.mode;
        let (s, n, m, all) = (self.tableau.stages, free.len(), rows.len(), velocities.len());
        let start_velocities: Vec<Part> = constant(&self.start.velocity);
        let efforts: Vec<Vec<Part>> = self.efforts.iter().map(|efforts| constant(efforts.as_slice())).collect();
        let drives = self.mode.drives(&self.constant.laws);
        let still = vec![Part::zero(); all];
        for first in unknowns.clone().step_by(WIDTH) {
            let width = WIDTH.min(unknowns.end - first);
            let mut offsets = vec![still.clone(); stages.len()];
            let mut end_velocities: Vec<Part> = constant(velocities);
            let mut pushes: Vec<Vec<Part>> = multipliers.iter().map(|own| constant(own)).collect();
            for part in 0..width {
                let unknown = first + part;
                if unknown < (s - 1) * n {
                    offsets[unknown / n][free[unknown % n]] = Part::parameter(0.0, part);
                } else if unknown < s * n {
                    let freedom = free[unknown - (s - 1) * n];
                    end_velocities[freedom] = Part::parameter(velocities[freedom], part);
                } else {
                    let (stage, row) = ((unknown - s * n) / m, rows[(unknown - s * n) % m]);
                    pushes[stage][row] = Part::parameter(multipliers[stage][row], part);
                }
            }
            let motion = StepMotion {
                figures: self.constant,
                tableau: self.tableau,
                step: Part::of(self.step),
                start: self.start,
                start_offsets: &still,
                start_velocities: &start_velocities,
                stages,
                offsets: &offsets,
                end_velocities: &end_velocities,
                efforts: &efforts,
                mode: InMode { drives: &drives, closed: &self.mode.constant, multipliers: &pushes },
            };
            for (row, value) in self.mode.select(&motion.residual(), all).into_iter().enumerate() {
                (0..width).for_each(|part| matrix[(row, first - unknowns.start + part)] = value.parts[part]);
            }
        }
    }
}

/// A loop joint with constant numbers.
pub fn lifted<T: Number>(joint: &LoopFigures<f64>) -> LoopFigures<T> {
    let end = |end: &End<f64>| {
        let Frame { axes, origin } = end.frame;
        End { body: end.body, frame: Frame { axes: axes.map(|column| column.map(T::of)), origin: origin.map(T::of) } }
    };
    LoopFigures { kind: joint.kind, a: end(&joint.a), b: end(&joint.b), length: T::of(joint.length) }
}

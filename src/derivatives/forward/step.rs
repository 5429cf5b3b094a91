//! One step of the scheme solved to rounding, with the factors of its exact derivatives.
//!
//! Newton's method on [`crate::derivatives::forward::stage_equations`] begins with stages on straight lines. Its matrix comes from dual numbers, and
//! is kept while it shrinks the residuals fast. The matrix at the solution is the one of the implicit function theorem:
//!
//! ```text
//!     R(u; x) = 0        R_u δu = −R_x δx
//! ```

use crate::derivatives::equations::figures::Figures;
use crate::derivatives::forward::stage_equations::{BothFigures, StepMotion};
use crate::derivatives::numbers::dual::Dual;
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// Derivatives that are computed at once.
pub const WIDTH: usize = 8;
/// Numbers with derivatives.
pub type Part = Dual<WIDTH>;

/// Iterations; about six are made.
const ITERATIONS: usize = 60;
/// The matrix is renewed if a correction is larger than this part of the one before.
const SLOW: f64 = 0.1;
/// Corrections this small (rad or m) that do not shrink any more are rounding.
const ROUNDING: f64 = 1e-10;

/// A step that is solved.
pub struct SolvedStep {
    /// The stages i = 2..s; the last one is the end, with its velocities and time.
    pub stages: Vec<State>,
    /// R_u, factored.
    pub factors: LU<f64, Dyn, Dyn>,
}

/// A step that is to be solved.
pub struct StepProblem<'p> {
    pub mechanism: &'p Mechanism,
    pub figures: &'p BothFigures<f64>,
    /// The same as constants with derivatives.
    pub constant: &'p BothFigures<Part>,
    pub tableau: &'p Tableau,
    pub start: &'p State,
    /// h (s).
    pub step: f64,
    /// Efforts from outside at all stages (n each).
    pub efforts: &'p [DVector<f64>],
}

impl<T: Number> BothFigures<T> {
    /// The figures of a mechanism with frames on its bodies, each number as `take` makes it of the double.
    pub fn taken(mechanism: &Mechanism, frames: &[Pose], take: impl Fn(usize, f64) -> T) -> Self {
        let mut count = 0..;
        let plain = Figures::taken(mechanism, frames, &mut |value| take(count.next().unwrap_or_default(), value));
        let mut count = 0..;
        let moving = Figures::taken(mechanism, frames, &mut |value| {
            let value = take(count.next().unwrap_or_default(), value);
            Jet { value, rate: T::zero(), acceleration: T::zero() }
        });
        BothFigures { plain, moving }
    }
}

impl StepProblem<'_> {
    /// Solves it; `None` if the iteration does not converge.
    pub fn solve(&self) -> Option<SolvedStep> {
        let s = self.tableau.stages;
        let mut stages: Vec<State> = (1..s)
            .map(|i| {
                let mut stage = self.start.clone();
                let gone = self.step * self.tableau.nodes[i];
                let along: Vec<f64> = self.start.velocity.iter().map(|rate| gone * rate).collect();
                stage.displace(self.mechanism, &along);
                stage.time = self.start.time + gone;
                stage
            })
            .collect();
        let mut velocities = self.start.velocity.clone();
        let mut factors: Option<LU<f64, Dyn, Dyn>> = None;
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let matrix = match factors.take() {
                Some(kept) => kept,
                None => self.factors(&stages, &velocities)?,
            };
            let correction = matrix.solve(&self.residual(&stages, &velocities))?;
            let n = velocities.len();
            let size = correction.rows(0, (s - 1) * n).amax();
            if !size.is_finite() {
                return None;
            }
            for (index, stage) in stages.iter_mut().enumerate() {
                let moved: Vec<f64> = correction.rows(index * n, n).iter().map(|part| -part).collect();
                stage.displace(self.mechanism, &moved);
            }
            velocities.iter_mut().zip(correction.rows((s - 1) * n, n).iter()).for_each(|(rate, part)| *rate -= part);
            if size < ROUNDING && size >= 0.25 * last || size == 0.0 {
                let factors = self.factors(&stages, &velocities)?;
                let end = stages.last_mut()?;
                end.velocity = velocities;
                end.time = self.start.time + self.step;
                return Some(SolvedStep { stages, factors });
            }
            if size <= SLOW * last {
                factors = Some(matrix);
            }
            last = size;
        }
        None
    }

    fn residual(&self, stages: &[State], velocities: &[f64]) -> DVector<f64> {
        let n = velocities.len();
        let efforts: Vec<Vec<f64>> = self.efforts.iter().map(|efforts| efforts.iter().copied().collect()).collect();
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
        };
        DVector::from_vec(motion.residual())
    }

    /// R_u at some stages, factored; `None` if it is singular.
    fn factors(&self, stages: &[State], velocities: &[f64]) -> Option<LU<f64, Dyn, Dyn>> {
        let n = velocities.len();
        let count = (stages.len() + 1) * n;
        let mut matrix = DMatrix::zeros(count, count);
        let constant = |value: &f64| Part::of(*value);
        let start_velocities: Vec<Part> = self.start.velocity.iter().map(constant).collect();
        let efforts: Vec<Vec<Part>> =
            self.efforts.iter().map(|efforts| efforts.iter().map(constant).collect()).collect();
        let still = vec![Part::zero(); n];
        for first in (0..count).step_by(WIDTH) {
            let width = WIDTH.min(count - first);
            let mut offsets = vec![still.clone(); stages.len()];
            let mut end_velocities: Vec<Part> = velocities.iter().map(constant).collect();
            for part in 0..width {
                let (stage, freedom) = ((first + part) / n, (first + part) % n);
                match offsets.get_mut(stage) {
                    Some(offsets) => offsets[freedom] = Part::parameter(0.0, part),
                    None => end_velocities[freedom] = Part::parameter(velocities[freedom], part),
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
            };
            for (row, value) in motion.residual().into_iter().enumerate() {
                (0..width).for_each(|part| matrix[(row, first + part)] = value.parts[part]);
            }
        }
        let factors = matrix.lu();
        factors.is_invertible().then_some(factors)
    }
}

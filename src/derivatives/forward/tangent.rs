//! The derivatives of a state by parameters, carried from step to step.
//!
//! ```text
//!     R_u δu = −(R_q δq₀ + R_v δv₀ + R_θ + R_τ ∂τ/∂θ)        δq̄ = δq₀ + δ_s,   δv̄        forward, a column for each parameter
//! ```
//!
//! The steps of the run are kept: the derivative is exact for their sequence. Turns of ball joints are twists about the
//! axes of the child, at the start and at the end: δq̄ = R_relᵀ δq₀ + δ_s.

use crate::derivatives::forward::stage_equations::{BothFigures, StepMotion};
use crate::derivatives::forward::step::{Part, SolvedStep, StepProblem, WIDTH};
use crate::derivatives::numbers::number::Number;
use crate::mechanism::description::joint::{FreeRotation, Pose, rotation_from_wxyz};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector, Vector3};

/// Derivatives of a state by p parameters.
#[derive(Clone, Debug)]
pub struct Tangent {
    /// ∂q/∂θ (n × p).
    pub positions: DMatrix<f64>,
    /// ∂v/∂θ (n × p).
    pub velocities: DMatrix<f64>,
}

/// The figures with their derivatives by some parameters, [`WIDTH`] at a time.
pub struct Varied(Vec<BothFigures<Part>>);

impl Varied {
    /// `slopes` are the derivatives of all figures by each parameter, in their order.
    pub fn new(mechanism: &Mechanism, frames: &[Pose], slopes: &[Vec<f64>]) -> Self {
        let of = |slopes: &[Vec<f64>]| {
            BothFigures::taken(mechanism, frames, |entry, value| {
                let mut part = Part::of(value);
                for (own, slopes) in part.parts.iter_mut().zip(slopes) {
                    *own = slopes.get(entry).copied().unwrap_or(0.0);
                }
                part
            })
        };
        Varied(slopes.chunks(WIDTH).map(of).collect())
    }
}

impl Tangent {
    /// Goes on over a solved step, with the derivatives of the efforts at all stages by the parameters (n × p each); `None` if the factors are
    /// singular.
    pub fn advance(
        &mut self,
        problem: &StepProblem,
        solved: &SolvedStep,
        varied: &Varied,
        efforts: &[DMatrix<f64>],
    ) -> Option<()> {
        let StepProblem { mechanism, tableau, start, .. } = problem;
        let n = start.velocity.len();
        let end = solved.stages.last()?;
        for (chunk, figures) in varied.0.iter().enumerate() {
            let first = chunk * WIDTH;
            let width = WIDTH.min(self.positions.ncols() - first);
            let with = |value: f64, of: &DMatrix<f64>, row: usize| {
                let mut part = Part::of(value);
                (0..width).for_each(|index| part.parts[index] = of[(row, first + index)]);
                part
            };
            let start_offsets: Vec<Part> = (0..n).map(|row| with(0.0, &self.positions, row)).collect();
            let start_velocities: Vec<Part> =
                (0..n).map(|row| with(start.velocity[row], &self.velocities, row)).collect();
            let driven: Vec<Vec<Part>> = (problem.efforts.iter().zip(efforts))
                .map(|(values, slopes)| (0..n).map(|row| with(values[row], slopes, row)).collect())
                .collect();
            let end_velocities: Vec<Part> = end.velocity.iter().map(|&rate| Part::of(rate)).collect();
            let motion = StepMotion {
                figures,
                tableau,
                step: Part::of(problem.step),
                start,
                start_offsets: &start_offsets,
                start_velocities: &start_velocities,
                stages: &solved.stages,
                offsets: &vec![vec![Part::zero(); n]; solved.stages.len()],
                end_velocities: &end_velocities,
                efforts: &driven,
            };
            let residual = motion.residual();
            let right = DMatrix::from_fn(residual.len(), width, |row, part| -residual[row].parts[part]);
            let found = solved.factors.solve(&right)?;
            for part in 0..width {
                let column = first + part;
                let carried = carried(mechanism, start, end, &self.positions.column(column).into_owned());
                let moved = found.column(part).rows((tableau.stages - 2) * n, n).into_owned();
                self.positions.set_column(column, &(carried + moved));
                self.velocities.set_column(column, &found.column(part).rows((tableau.stages - 1) * n, n));
            }
        }
        Some(())
    }
}

/// A slight motion at the start of a step, in the coordinates of its end: turns of ball joints are about the axes of the child.
fn carried(mechanism: &Mechanism, start: &State, end: &State, motion: &DVector<f64>) -> DVector<f64> {
    let mut carried = motion.clone();
    for body in mechanism.bodies.iter().filter(|body| body.joint.kind.rotation() == FreeRotation::Ball) {
        let slides = body.joint.kind.translation_axes().len();
        let (slot, row) = (body.joint.position_index + slides, body.joint.velocity_index + slides);
        let rotation = |of: &State| rotation_from_wxyz(&of.position[slot..slot + 4]);
        let turn = Vector3::new(motion[row], motion[row + 1], motion[row + 2]);
        let turned = rotation(end).transpose() * (rotation(start) * turn);
        carried.rows_mut(row, 3).copy_from(&turned);
    }
    carried
}

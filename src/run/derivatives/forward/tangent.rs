//! The derivatives of a state by parameters, carried from step to step.
//!
//! ```text
//!     R_u δu = −(R_q δq₀ + R_v δv₀ + R_θ + R_h δh + R_τ δτ)        δq̄ = δq₀ + δ_s,   δv̄        forward, a column for each parameter
//! ```
//!
//! | step | δh | δt̄ |
//! |---|---|---|
//! | to a given instant | −δt₀ | 0 |
//! | to an event φ(q̄, v̄, t̄) = 0 | so that δφ = 0 | δt₀ + δh |
//!
//! The steps of the run are kept: the derivative is exact for their sequence. Turns of ball joints are twists about the
//! axes of the child, at the start and at the end: δq̄ = R_relᵀ δq₀ + δ_s.

use crate::derivatives::equations::closed::ClosedContacts;
use crate::derivatives::equations::figures::Figures;
use crate::derivatives::equations::laws::Laws;
use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::stage_equations::{BothFigures, InMode, StepMotion};
use crate::derivatives::forward::step::{Part, SolvedStep, StepProblem, WIDTH, constant};
use crate::derivatives::numbers::number::Number;
use crate::instant::holding::elements::Elements;
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
    /// ∂t/∂θ (p): of the event at which the state is; zero elsewhere (s per unit).
    pub times: DVector<f64>,
}

/// The figures with their derivatives by some parameters.
pub struct Varied {
    /// [`WIDTH`] at a time.
    chunks: Vec<BothFigures<Part>>,
    /// For each parameter; `None` if it changes no figure.
    slopes: Vec<Option<FigureSlopes>>,
}

/// The derivatives of the inputs of a step.
pub struct InputSlopes<'i> {
    /// Of the efforts at all stages by the parameters at fixed times (n × p each).
    pub efforts: &'i [DMatrix<f64>],
    /// Of the efforts at all stages by time (n each).
    pub rates: &'i [DVector<f64>],
    /// Closed contacts, a list for each [`WIDTH`] parameters.
    pub closed: &'i [ClosedContacts<Part>],
}

impl Varied {
    /// `slopes` are the derivatives of all figures by each parameter, in their order.
    pub(crate) fn new(mechanism: &Mechanism, elements: &Elements, frames: &[Pose], slopes: &[Vec<f64>]) -> Self {
        let of = |slopes: &[Vec<f64>]| {
            BothFigures::taken(mechanism, elements, frames, |entry, value| {
                let mut part = Part::of(value);
                for (own, slopes) in part.parts.iter_mut().zip(slopes) {
                    *own = slopes.get(entry).copied().unwrap_or(0.0);
                }
                part
            })
        };
        // States and jumps are computed with the first ones, also without parameters.
        let chunks = if slopes.is_empty() { vec![of(&[])] } else { slopes.chunks(WIDTH).map(of).collect() };
        let constant: Figures<f64> = Figures::taken(mechanism, frames, &mut |value| value);
        let slope = |slopes: &Vec<f64>| {
            let mut given = slopes.iter().copied();
            let mut take = |_: f64| given.next().unwrap_or(0.0);
            let plain = Figures::taken(mechanism, frames, &mut take);
            let laws = Laws::taken(mechanism, elements, frames, &mut take);
            FigureSlopes::new(&constant, plain, laws)
        };
        let moves = |slopes: &Vec<f64>| slopes.iter().any(|slope| *slope != 0.0);
        let slopes = slopes.iter().map(|slopes| moves(slopes).then(|| slope(slopes))).collect();
        Varied { chunks, slopes }
    }

    /// The derivatives of all figures by each parameter; `None` if it changes none.
    pub(in crate::derivatives) fn slopes(&self) -> &[Option<FigureSlopes>] {
        &self.slopes
    }

    /// The figures with their derivatives by [`WIDTH`] parameters each.
    pub fn chunks(&self) -> &[BothFigures<Part>] {
        &self.chunks
    }
}

/// A value with the derivatives of a row by the parameters from `first` on.
pub fn with(value: f64, of: &DMatrix<f64>, row: usize, first: usize) -> Part {
    let mut part = Part::of(value);
    for (index, own) in part.parts.iter_mut().enumerate().take(of.ncols() - first) {
        *own = of[(row, first + index)];
    }
    part
}

/// The starts of a step with their derivatives.
struct Starts<'s> {
    offsets: &'s [Part],
    velocities: &'s [Part],
    step: Part,
    efforts: &'s [Vec<Part>],
    closed: &'s ClosedContacts<Part>,
}

impl Tangent {
    /// Goes on over a solved step whose length varies by δh (p); the time at the end varies by δt₀ + δh.
    pub(super) fn carry_whole(
        &mut self,
        problem: &StepProblem,
        solved: &SolvedStep,
        varied: &Varied,
        slopes: &InputSlopes,
        longer: &DVector<f64>,
    ) -> Option<()> {
        let StepProblem { mechanism, tableau, start, mode, .. } = problem;
        let n = start.velocity.len();
        let end = solved.stages.last()?;
        for (chunk, figures) in varied.chunks().iter().enumerate() {
            let first = chunk * WIDTH;
            let width = WIDTH.min(self.positions.ncols() - first);
            let offsets: Vec<Part> = (0..n).map(|row| with(0.0, &self.positions, row, first)).collect();
            let velocities: Vec<Part> =
                (0..n).map(|row| with(start.velocity[row], &self.velocities, row, first)).collect();
            let mut step = Part::of(problem.step);
            (0..width).for_each(|index| step.parts[index] = longer[first + index]);
            let efforts: Vec<Vec<Part>> = (0..tableau.stages)
                .map(|stage| {
                    let row = |row: usize| {
                        let mut effort = with(problem.efforts[stage][row], &slopes.efforts[stage], row, first);
                        for (index, part) in effort.parts.iter_mut().enumerate().take(width) {
                            let later = self.times[first + index] + tableau.nodes[stage] * longer[first + index];
                            *part += slopes.rates[stage][row] * later;
                        }
                        effort
                    };
                    (0..n).map(row).collect()
                })
                .collect();
            let closed = &slopes.closed[chunk];
            let starts = Starts { offsets: &offsets, velocities: &velocities, step, efforts: &efforts, closed };
            let found = columns(problem, solved, figures, &starts, width)?;
            for part in 0..width {
                let column = first + part;
                let mut positions = carried(mechanism, start, end, &self.positions.column(column).into_owned());
                let free = mode.free.len();
                let mut rates = DVector::zeros(n);
                for (row, &freedom) in mode.free.iter().enumerate() {
                    positions[freedom] += found[((tableau.stages - 2) * free + row, part)];
                    rates[freedom] = found[((tableau.stages - 1) * free + row, part)];
                }
                self.positions.set_column(column, &positions);
                self.velocities.set_column(column, &rates);
            }
        }
        self.times += longer;
        Some(())
    }
}

/// ∂q̄/∂h and ∂v̄/∂h of a solved step (n each), for efforts that change at these rates at its stages; `None` if the factors are singular.
pub(super) fn by_length_whole(
    problem: &StepProblem,
    solved: &SolvedStep,
    rates: &[DVector<f64>],
) -> Option<(DVector<f64>, DVector<f64>)> {
    let StepProblem { tableau, start, mode, .. } = problem;
    let n = start.velocity.len();
    let efforts: Vec<Vec<Part>> = (0..tableau.stages)
        .map(|stage| {
            let row = |row: usize| {
                let mut effort = Part::of(problem.efforts[stage][row]);
                effort.parts[0] = rates[stage][row] * tableau.nodes[stage];
                effort
            };
            (0..n).map(row).collect()
        })
        .collect();
    let offsets = vec![Part::zero(); n];
    let velocities: Vec<Part> = constant(&start.velocity);
    let step = Part::parameter(problem.step, 0);
    let closed = &mode.constant;
    let starts = Starts { offsets: &offsets, velocities: &velocities, step, efforts: &efforts, closed };
    let found = columns(problem, solved, problem.constant, &starts, 1)?;
    let free = mode.free.len();
    let (mut positions, mut velocities) = (DVector::zeros(n), DVector::zeros(n));
    for (row, &freedom) in mode.free.iter().enumerate() {
        positions[freedom] = found[((tableau.stages - 2) * free + row, 0)];
        velocities[freedom] = found[((tableau.stages - 1) * free + row, 0)];
    }
    Some((positions, velocities))
}

/// `−R_u⁻¹ R_x δx`: the derivatives of all unknowns.
fn columns(
    problem: &StepProblem,
    solved: &SolvedStep,
    figures: &BothFigures<Part>,
    starts: &Starts,
    width: usize,
) -> Option<DMatrix<f64>> {
    let (n, stages, free) = (problem.start.velocity.len(), problem.tableau.stages, &problem.mode.free);
    // The stages and the end go along with the start, so that the unknowns are small and keep their digits: h δv₀ + v₀ δh and δv₀.
    let mut gone = vec![Part::zero(); n];
    let mut end_velocities: Vec<Part> = constant(&solved.stages.last()?.velocity);
    for &freedom in free {
        let velocity = starts.velocities[freedom];
        gone[freedom].parts = (starts.step * velocity).parts;
        end_velocities[freedom].parts = velocity.parts;
    }
    let along = |node: &f64| gone.iter().map(|gone| gone.times(*node)).collect();
    let offsets: Vec<Vec<Part>> = problem.tableau.nodes[1..].iter().map(along).collect();
    let multipliers: Vec<Vec<Part>> = solved.multipliers.iter().map(|own| constant(own)).collect();
    let drives = problem.mode.drives(&figures.laws);
    let motion = StepMotion {
        figures,
        tableau: problem.tableau,
        step: starts.step,
        start: problem.start,
        start_offsets: starts.offsets,
        start_velocities: starts.velocities,
        stages: &solved.stages,
        offsets: &offsets,
        end_velocities: &end_velocities,
        efforts: starts.efforts,
        mode: InMode { drives: &drives, closed: starts.closed, multipliers: &multipliers },
    };
    let residual = problem.mode.select(&motion.residual(), n);
    let right = DMatrix::from_fn(residual.len(), width, |row, part| -residual[row].parts[part]);
    let mut found = solved.factors.solve(&right);
    for (row, &freedom) in free.iter().enumerate() {
        for part in 0..width {
            found[((stages - 2) * free.len() + row, part)] += gone[freedom].parts[part];
            found[((stages - 1) * free.len() + row, part)] += end_velocities[freedom].parts[part];
        }
    }
    Some(found)
}

/// A slight motion at the start of a step, in the coordinates of its end: turns of ball joints are about the axes of the child.
pub(super) fn carried(mechanism: &Mechanism, start: &State, end: &State, motion: &DVector<f64>) -> DVector<f64> {
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

//! The matrix of a step of a tree with closures: the matrix of its tree, and blocks of the closures, stage by stage.
//!
//! ```text
//!     rows of stage k       − f_k ∂(Gᵀ Λ_k)/∂δ_k        − f_k Gᵀ  by Λ_k                 f_k = h², or h b_s
//!     g of stage k            G(Q_k)  by δ_k
//!     G v̄ at the end          ∂(G v̄)/∂δ_s               G(q̄)  by v̄
//! ```
//!
//! These blocks come from numbers with derivatives at one stage each. Equations and unknowns are as in
//! [`crate::derivatives::forward::stage_equations`], in the same order.

use crate::derivatives::equations::closures::{closures, push};
use crate::derivatives::equations::placed::{Offsets, place};
use crate::derivatives::equations::residual::{Load, along_freedoms};
use crate::derivatives::forward::stage_equations::{InMode, StepMotion};
use crate::derivatives::forward::step::{Part, StepMode, StepProblem, WIDTH, constant};
use crate::derivatives::forward::tree::family::Family;
use crate::derivatives::forward::tree::matrix::TreeMatrix;
use crate::derivatives::forward::tree::step::TreeStep;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;
use std::ops::Range;

/// Derivatives of closures at a stage by some unknowns: its displacements (n), then its multipliers (m).
struct Blocks {
    /// Of Gᵀ Λ along the freedoms that move (n rows).
    pushes: DMatrix<f64>,
    /// Of g (m rows); zero by multipliers.
    gaps: DMatrix<f64>,
}

impl StepProblem<'_> {
    /// Whether it has the equations of a tree and of closures alone.
    pub(in crate::derivatives::forward) fn is_looped(&self) -> bool {
        let figures = &self.figures.plain;
        figures.point_springs.is_empty() && figures.wrenches.is_empty() && self.mode.closed.touches.is_empty()
    }

    /// R_u at some stages of a tree with closures.
    pub(in crate::derivatives::forward) fn looped_matrix(
        &self,
        stages: &[State],
        velocities: &[f64],
        multipliers: &[Vec<f64>],
    ) -> DMatrix<f64> {
        let (s, n, m) = (self.tableau.stages, self.mode.free.len(), self.mode.rows.len());
        let family = Family::new(&self.figures.plain, &self.mode.free);
        let step = TreeStep::new(self, &family, stages, velocities);
        let mut matrix = DMatrix::zeros(self.mode.size(s), self.mode.size(s));
        TreeMatrix::new(&step).copy_to(&mut matrix);
        for (k, multipliers) in multipliers.iter().enumerate() {
            let state = if k == 0 { self.start } else { &stages[k - 1] };
            // The start is not displaced.
            let first = if k == 0 { n } else { 0 };
            let Blocks { pushes, gaps } = self.blocks(state, multipliers, first..n + m);
            let pushes = pushes * -step.factor(k);
            let by_multipliers = pushes.columns(n - first, m);
            matrix.view_mut((k * n, s * n + k * m), (n, m)).copy_from(&by_multipliers);
            if k == 0 {
                continue;
            }
            let gradient = gaps.columns(0, n);
            let mut own = matrix.view_mut((k * n, (k - 1) * n), (n, n));
            own += pushes.columns(0, n);
            matrix.view_mut((s * n + (k - 1) * m, (k - 1) * n), (m, n)).copy_from(&gradient);
            if k + 1 == s {
                let last = s * n + (s - 1) * m;
                matrix.view_mut((last, (s - 2) * n), (m, n)).copy_from(&self.rates_by_places(stages, velocities));
                matrix.view_mut((last, (s - 1) * n), (m, n)).copy_from(&gradient);
            }
        }
        matrix
    }

    /// The columns of all multipliers in the motion equations (s n × s m).
    pub(in crate::derivatives::forward) fn push_columns(&self, stages: &[State]) -> DMatrix<f64> {
        let (s, n, m) = (self.tableau.stages, self.mode.free.len(), self.mode.rows.len());
        let mut columns = DMatrix::zeros(s * n, s * m);
        let none = vec![0.0; self.mode.row_count];
        for (k, state) in std::iter::once(self.start).chain(stages).enumerate() {
            let pushes = self.blocks(state, &none, n..n + m).pushes * -self.factor(k);
            columns.view_mut((k * n, k * m), (n, m)).copy_from(&pushes);
        }
        columns
    }

    /// The blocks of a stage, by a range of its unknowns.
    fn blocks(&self, state: &State, multipliers: &[f64], unknowns: Range<usize>) -> Blocks {
        let (plain, free, rows) = (&self.constant.plain, &self.mode.free, &self.mode.rows);
        let (n, m, count) = (free.len(), rows.len(), unknowns.len());
        let anchors = &self.mode.constant.anchors;
        let still = vec![Part::zero(); self.start.velocity.len()];
        let mut found = Blocks { pushes: DMatrix::zeros(n, count), gaps: DMatrix::zeros(m, count) };
        for first in unknowns.clone().step_by(WIDTH) {
            let width = WIDTH.min(unknowns.end - first);
            let (mut offsets, mut own) = (still.clone(), constant::<Part>(multipliers));
            for part in 0..width {
                match free.get(first + part) {
                    Some(&freedom) => offsets[freedom] = Part::parameter(0.0, part),
                    None => {
                        let row = rows[first + part - n];
                        own[row] = Part::parameter(multipliers[row], part);
                    }
                }
            }
            let offsets = Offsets { from: self.start, to: state, first: &still, second: &offsets, motion: &[] };
            let placed = place(plain, &offsets);
            let mut loads = vec![Load { force: Vector::zero(), torque: Vector::zero() }; placed.len()];
            let mut efforts = still.clone();
            let mut on_body = |body: Option<usize>, point: Vector<Part>, force: Vector<Part>, torque: Vector<Part>| {
                let Some(body) = body else { return };
                let arm = point - placed[body].frame.origin;
                loads[body].force = loads[body].force + force;
                loads[body].torque = loads[body].torque + torque + arm.cross(force);
            };
            let mut on_freedom = |freedom: usize, effort: Part| efforts[freedom] = efforts[freedom] + effort;
            push(plain, anchors, &placed, &own, &mut on_body, &mut on_freedom);
            let along = along_freedoms(plain, &placed, loads);
            let column = first - unknowns.start;
            let write = |to: &mut DMatrix<f64>, row: usize, value: Part| {
                (0..width).for_each(|part| to[(row, column + part)] = value.parts[part]);
            };
            for (row, &freedom) in free.iter().enumerate() {
                write(&mut found.pushes, row, along[freedom] + efforts[freedom]);
            }
            if first < n {
                let gaps = closures(plain, anchors, &placed, &offsets);
                rows.iter().enumerate().for_each(|(row, &own)| write(&mut found.gaps, row, gaps[own]));
            }
        }
        found
    }

    /// ∂(G v̄)/∂δ_s (m × n).
    fn rates_by_places(&self, stages: &[State], velocities: &[f64]) -> DMatrix<f64> {
        let StepMode { free, rows, constant: closed, .. } = self.mode;
        let mut found = DMatrix::zeros(rows.len(), free.len());
        let still = vec![Part::zero(); velocities.len()];
        let ended: Vec<Part> = constant(velocities);
        let mut offsets = vec![still.clone(); stages.len()];
        for (chunk, own) in free.chunks(WIDTH).enumerate() {
            let mut last = still.clone();
            own.iter().enumerate().for_each(|(part, &freedom)| last[freedom] = Part::parameter(0.0, part));
            offsets.iter_mut().last().into_iter().for_each(|of_end| of_end.clone_from(&last));
            let motion = StepMotion {
                figures: self.constant,
                tableau: self.tableau,
                step: Part::of(self.step),
                start: self.start,
                start_offsets: &still,
                start_velocities: &still,
                stages,
                offsets: &offsets,
                end_velocities: &ended,
                efforts: &[],
                mode: InMode { drives: &[], closed, multipliers: &[] },
            };
            let rates = motion.rates_at_end();
            for (row, &closure) in rows.iter().enumerate() {
                (0..own.len()).for_each(|part| found[(row, chunk * WIDTH + part)] = rates[closure].parts[part]);
            }
        }
        found
    }
}

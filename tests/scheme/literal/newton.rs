//! The matrix of Newton's iteration for the scheme word for word ([`crate::literal::scheme`]), written out.
//!
//! The residuals of its unknowns `Q_i − q` (i = 2..s) and `Λ_k` (k = 1..s−1) are (2.5.11a, b, d, e) put into each other, and (2.5.11c),
//!
//! ```text
//!     Q_i − q − h Σ_j a_ij M⁻¹ (p + h Σ_k ā_jk (F_k − Dg(Q_k)ᵀ Λ_k))   [m, 1],      g(Q_i) − g(q)
//! ```
//!
//! so that with `Â_ik = Σ_j a_ij ā_jk` their derivatives are `1 + h² Â_ik M⁻¹ ∂(Dg(Q_k)ᵀ Λ_k − F_k)/∂Q_k`, `h² Â_ik M⁻¹ Dg(Q_k)ᵀ` and `Dg(Q_i)`: a
//! square matrix of (s − 1) (12 n + d) rows, in the symbols of [`crate::literal::scheme`]. The m equations of the closed contacts
//! ([`crate::literal::touches`]) and their multipliers come after the equations g at each stage, so that d counts both together. Their derivatives
//! are found by differences.

use crate::literal::coordinates::BODY_COORDINATES;
use crate::literal::scheme::Literal;
use crate::literal::touches::{TouchStages, TouchStep};
use nalgebra::{DMatrix, DVector};

/// Step of the differences that give the derivatives of forces and contacts in Newton's matrix, which need not be exact.
const DIFFERENCE: f64 = 1e-6;

impl Literal<'_> {
    /// Adds the derivative of the forces by `Q_2 … Q_s` to Newton's matrix, by differences.
    pub(crate) fn add_force_derivatives(
        &self,
        q: &DVector<f64>,
        velocity: &DVector<f64>,
        increments: &[DVector<f64>],
        step: f64,
        forces: &[DVector<f64>],
        matrix: &mut DMatrix<f64>,
    ) {
        if self.mechanism.forces.is_empty() {
            return;
        }
        let (s, n) = (self.tableau.stages, q.len());
        let mut moved = increments.to_vec();
        for (stage, coordinate) in (1..s).flat_map(|stage| (0..n).map(move |coordinate| (stage, coordinate))) {
            moved[stage][coordinate] += DIFFERENCE;
            let changed = self.forces(q, velocity, &moved, step);
            moved[stage][coordinate] = increments[stage][coordinate];
            for k in 0..s - 1 {
                let slope = (&changed[k] - &forces[k]).component_div(&self.mass) / DIFFERENCE;
                for i in 1..s {
                    let weight = step * step * self.tableau.a_hat[(i - 1) * (s - 1) + k];
                    let mut column = matrix.view_mut(((i - 1) * n, (stage - 1) * n + coordinate), (n, 1));
                    column -= &slope * weight;
                }
            }
        }
    }

    /// Adds the derivative of the contacts' equations and of the forces of their multipliers by `Q_2 … Q_s` to Newton's matrix, by differences.
    pub(crate) fn add_touch_derivatives(
        &self,
        at: &TouchStep,
        increments: &[DVector<f64>],
        here: &TouchStages,
        multipliers: &[DVector<f64>],
        matrix: &mut DMatrix<f64>,
    ) -> Option<()> {
        let (s, n, g, m) = (self.tableau.stages, self.mass.len(), self.constraints.len(), here.ends.nrows());
        if m == 0 {
            return Some(());
        }
        let ends = self.mechanism.touches.iter().flat_map(|joint| [joint.a.body, joint.b.body]).flatten();
        let touching: Vec<usize> = ends.collect();
        let coordinates: Vec<usize> = (0..n).filter(|index| touching.contains(&(index / BODY_COORDINATES))).collect();
        let pulled = |stages: &TouchStages, k: usize| stages.pulls[k].tr_mul(&multipliers[k].rows(g, m));
        let before: Vec<DVector<f64>> = (0..s - 1).map(|k| pulled(here, k)).collect();
        let mut moved = increments.to_vec();
        for (stage, &coordinate) in (1..s).flat_map(|stage| coordinates.iter().map(move |index| (stage, index))) {
            moved[stage][coordinate] += DIFFERENCE;
            let changed = at.at(&moved)?;
            moved[stage][coordinate] = increments[stage][coordinate];
            let column = (stage - 1) * n + coordinate;
            for k in 0..s - 1 {
                let slope = (pulled(&changed, k) - &before[k]).component_div(&self.mass) / DIFFERENCE;
                for i in 1..s {
                    let weight = at.step * at.step * self.tableau.a_hat[(i - 1) * (s - 1) + k];
                    let mut column = matrix.view_mut(((i - 1) * n, column), (n, 1));
                    column += &slope * weight;
                }
            }
            for i in 1..s {
                let slope = (&changed.rows[i] - &here.rows[i]) / DIFFERENCE;
                matrix.view_mut(((s - 1) * n + (i - 1) * (g + m) + g, column), (m, 1)).copy_from(&slope);
            }
        }
        Some(())
    }

    /// Derivative of the residual with respect to `(Q_2 … Q_s, Λ_1 … Λ_{s−1} ÷ scale)`, for `Dg(Q_i)` with the pulls of the contacts below.
    pub(crate) fn newton_matrix(
        &self,
        step: f64,
        jacobians: &[DMatrix<f64>],
        multipliers: &[DVector<f64>],
        scale: &DVector<f64>,
    ) -> DMatrix<f64> {
        let (s, n, g, d) = (self.tableau.stages, self.mass.len(), self.constraints.len(), scale.len());
        let mut matrix = DMatrix::zeros((s - 1) * (n + d), (s - 1) * (n + d));
        for i in 1..s {
            for coordinate in 0..n {
                matrix[((i - 1) * n + coordinate, (i - 1) * n + coordinate)] = 1.0;
            }
            let constraint_rows = (s - 1) * n + (i - 1) * d;
            matrix.view_mut((constraint_rows, (i - 1) * n), (g, n)).copy_from(&jacobians[i].rows(0, g));
            for k in 0..s - 1 {
                let weight = step * step * self.tableau.a_hat[(i - 1) * (s - 1) + k];
                for column in 0..d {
                    for row in 0..n {
                        matrix[((i - 1) * n + row, (s - 1) * n + k * d + column)] =
                            weight * jacobians[k][(column, row)] * scale[column] / self.mass[row];
                    }
                }
                if k > 0 {
                    // d(Dg(Q)ᵀ Λ)/dQ; zero at the first stage, because Q_1 = q is given.
                    for (constraint, multiplier) in self.constraints.iter().zip(multipliers[k].iter()) {
                        constraint.add_second_derivative(|row, column, entry| {
                            matrix[((i - 1) * n + row, (k - 1) * n + column)] +=
                                weight * multiplier * entry / self.mass[row];
                        });
                    }
                }
            }
        }
        matrix
    }

    /// `1 / (Dg M⁻¹ Dgᵀ)_rr` at q: the multiplier whose force moves the constraint by about one unit. Newton's unknown is
    /// the multiplier measured in it, so that light and heavy bodies mix without harm. For `Dg` with K of the contacts below.
    pub(crate) fn multiplier_scale(&self, jacobian: &DMatrix<f64>) -> DVector<f64> {
        DVector::from_iterator(
            jacobian.nrows(),
            jacobian.row_iter().map(|row| 1.0 / row.iter().zip(self.mass.iter()).map(|(j, m)| j * j / m).sum::<f64>()),
        )
    }
}

//! The matrix of Newton's iteration for the scheme word for word ([`crate::literal::scheme`]), written out.
//!
//! The residuals of its unknowns `Q_i − q` (i = 2..s) and `Λ_k` (k = 1..s−1) are (2.5.11a, b, d, e) put into each other, and (2.5.11c),
//!
//! ```text
//!     Q_i − q − h Σ_j a_ij M⁻¹ (p + h Σ_k ā_jk (F_k − Dg(Q_k)ᵀ Λ_k))   [m, 1],      g(Q_i) − g(q)
//! ```
//!
//! so that with `Â_ik = Σ_j a_ij ā_jk` their derivatives are `1 + h² Â_ik M⁻¹ ∂(Dg(Q_k)ᵀ Λ_k − F_k)/∂Q_k`, `h² Â_ik M⁻¹ Dg(Q_k)ᵀ` and
//! `Dg(Q_i)`: a square matrix of (s − 1) (12 n + d) rows, in the symbols of [`crate::literal::scheme`].

use crate::literal::scheme::Literal;
use nalgebra::{DMatrix, DVector};

/// Step of the differences that give the derivative of the forces in Newton's matrix, which need not be exact.
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

    /// Derivative of the residual with respect to `(Q_2 … Q_s, Λ_1 … Λ_{s−1} ÷ scale)`.
    pub(crate) fn newton_matrix(
        &self,
        step: f64,
        jacobians: &[DMatrix<f64>],
        multipliers: &[DVector<f64>],
        scale: &DVector<f64>,
    ) -> DMatrix<f64> {
        let (s, n, d) = (self.tableau.stages, self.mass.len(), self.constraints.len());
        let mut matrix = DMatrix::zeros((s - 1) * (n + d), (s - 1) * (n + d));
        for i in 1..s {
            for coordinate in 0..n {
                matrix[((i - 1) * n + coordinate, (i - 1) * n + coordinate)] = 1.0;
            }
            let constraint_rows = (s - 1) * n + (i - 1) * d;
            matrix.view_mut((constraint_rows, (i - 1) * n), (d, n)).copy_from(&jacobians[i]);
            for k in 0..s - 1 {
                let weight = step * step * self.tableau.a_hat[(i - 1) * (s - 1) + k];
                for column in 0..d {
                    for row in 0..n {
                        matrix[((i - 1) * n + row, (s - 1) * n + k * d + column)] =
                            weight * jacobians[k][(column, row)] * scale[column] / self.mass[row];
                    }
                }
                if k > 0 {
                    // d(Dg(Q)ᵀ Λ)/dQ; the first stage has none because Q_1 = q is given.
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
    /// the multiplier measured in it, so that light and heavy bodies mix without harm.
    pub(crate) fn multiplier_scale(&self, q: &DVector<f64>) -> DVector<f64> {
        let jacobian = self.constraint_jacobian(q);
        DVector::from_iterator(
            self.constraints.len(),
            jacobian.row_iter().map(|row| 1.0 / row.iter().zip(self.mass.iter()).map(|(j, m)| j * j / m).sum::<f64>()),
        )
    }
}

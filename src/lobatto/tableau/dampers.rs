//! The share of a damper in the inertia of each row of the simplified Newton step.
//!
//! A damper c along a degree of freedom adds `h c Ā'` to its inertia H, which couples the rows k = 1 … s − 1; the stages are solved side by side, so
//! that each row takes a number instead:
//!
//! ```text
//!     (H + h c Ā') α = −ρ,   Ā' = Ā_kj, k, j < s          (H + h c κ_k) α_k = −ρ_k:      α ← α + (H + h c K)⁻¹ h c (K − Ā') α,   K = diag κ
//! ```
//!
//! For hard dampers the error is multiplied by `1 − K⁻¹ Ā'` in an iteration. The κ of the table make that matrix nilpotent: all its eigenvalues are
//! zero, and for any c no eigenvalue of `(H + h c K)⁻¹ h c (K − Ā')` exceeds 0.09, 0.15 and 0.18 for three, four and five stages. The best common κ of
//! all rows leaves 0.50, 0.69 and 0.78. Four iterations reduce any error by 4e-4, 0.03 and 0.3, with a common κ by 0.1, 0.7 and 1.8. They are
//! solutions of `det(λ − K⁻¹ Ā') = (λ − 1)^{s−1}`; of several the table has the one whose powers are the smallest.
//!
//! From six stages on the rows have a common κ, the largest `|μ|² / Re μ` of the eigenvalues μ of Ā', which all have positive real parts. Nilpotent
//! matrices are so far from normal there that the error grows first: by 87 in four iterations of nine stages.
//!
//! Source of the idea: P. J. van der Houwen, B. P. Sommeijer, Iterated Runge–Kutta methods on parallel computers, SIAM J. Sci. Stat. Comput. 12
//! (1991), section 3.

use crate::tableau::butcher::{MAXIMUM_STAGES, Tableau};
use nalgebra::DMatrix;
use std::sync::OnceLock;

/// κ of rows 1 … s − 1 for two to five stages.
const NILPOTENT: [&[f64]; 4] = [
    &[0.5],
    &[0.394_337_567_297, 0.211_324_865_405],
    &[0.326_316_905_664, 0.244_534_313_514, 0.104_433_388_87],
    &[0.176_312_229_292, 0.143_029_194_467, 0.079_032_997_594_2, 0.298_658_675_347],
];

/// κ of rows 1 … s − 1.
pub(crate) fn damper_shares(tableau: &Tableau) -> &'static [f64] {
    static COMMON: [OnceLock<Vec<f64>>; MAXIMUM_STAGES + 1] = [const { OnceLock::new() }; MAXIMUM_STAGES + 1];
    match NILPOTENT.get(tableau.stages - 2) {
        Some(shares) => shares,
        None => COMMON[tableau.stages].get_or_init(|| vec![common_share(tableau); tableau.stages - 1]),
    }
}

/// `Ā_kj`, k, j = 1 … s − 1.
fn coupling(tableau: &Tableau) -> DMatrix<f64> {
    let stages = tableau.stages;
    DMatrix::from_fn(stages - 1, stages - 1, |k, j| tableau.a_bar[k * stages + j])
}

/// The κ for all rows.
fn common_share(tableau: &Tableau) -> f64 {
    let eigenvalues = coupling(tableau).complex_eigenvalues();
    eigenvalues.iter().map(|value| value.norm_sqr() / value.re).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    /// The largest eigenvalue of an iteration with these κ for `h c / H`.
    fn contraction(tableau: &Tableau, shares: &[f64], ratio: f64) -> f64 {
        let shares = DMatrix::from_diagonal(&DVector::from_column_slice(shares));
        let mut rest = (&shares - coupling(tableau)) * ratio;
        for (k, mut row) in rest.row_iter_mut().enumerate() {
            row /= 1.0 + ratio * shares[(k, k)];
        }
        rest.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    }

    #[test]
    fn shares_of_dampers_make_the_iteration_nilpotent_for_hard_ones() {
        for stages in 2..=5 {
            let tableau = Tableau::of(stages).unwrap();
            let shares = damper_shares(tableau);
            let mut error = coupling(tableau);
            for (k, mut row) in error.row_iter_mut().enumerate() {
                row /= shares[k];
            }
            let error = DMatrix::identity(stages - 1, stages - 1) - error;
            let gone = error.pow(stages as u32 - 1);
            // Twelve digits of κ, and powers of a matrix that is not normal.
            assert!(gone.amax() < 1e-6, "{stages} stages: {}", gone.amax());
        }
    }

    #[test]
    fn iterations_contract_for_every_damper_and_more_with_a_share_for_each_row_than_with_a_common_one() {
        let bounds = [0.0, 0.09, 0.15, 0.18];
        for stages in 2..=MAXIMUM_STAGES {
            let tableau = Tableau::of(stages).unwrap();
            let worst = |shares: &[f64]| {
                (-8..=24)
                    .map(|tenth| contraction(tableau, shares, 10_f64.powf(f64::from(tenth) / 4.0)))
                    .fold(0.0, f64::max)
            };
            let (own, common) = (worst(damper_shares(tableau)), worst(&vec![common_share(tableau); stages - 1]));
            match bounds.get(stages - 2) {
                Some(bound) => assert!(
                    own <= bound + 1e-6 && (own < 0.5 * common || stages == 2),
                    "{stages} stages: {own}, {common}"
                ),
                None => assert!(own < 1.0, "{stages} stages: {own}"),
            }
        }
    }
}

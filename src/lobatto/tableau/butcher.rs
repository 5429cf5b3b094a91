//! The coefficients of the Lobatto IIIA–IIIB pair with any number of stages, as the sweeps use them.
//!
//! ```text
//!     c, b, A, Ā, Â, B, w, Ā B       symbols and formulas: exact.rs
//! ```
//!
//! They are computed with about 32 digits (`exact`) and rounded once; the rounding errors are kept for the uses that need them ([`Remainders`]).
//! Source: T. M. Tyranowski, PhD thesis, California Institute of Technology, 2014, (2.5.11).

use crate::numbers::extended::Extended;
use crate::tableau::exact::Exact;
use std::sync::OnceLock;

/// Fewest stages: two, where the scheme is RATTLE.
pub const MINIMUM_STAGES: usize = 2;
/// Largest number of stages: the order is then 30, beyond the use of doubles at any step size.
pub const MAXIMUM_STAGES: usize = 16;

/// Coefficients of the s-stage Lobatto IIIA–IIIB pair. Matrices are row-major; indices below count from 1 as in the
/// equations, so that the first stage (the known start of the step) is 1 and the last (its end) is s.
#[derive(Clone, Debug, PartialEq)]
pub struct Tableau {
    /// Number of stages s.
    pub stages: usize,
    /// Nodes `c_i`, i = 1..s, from 0 to 1 (s).
    pub nodes: Vec<f64>,
    /// Weights `b_i`, i = 1..s (s).
    pub weights: Vec<f64>,
    /// IIIA matrix A (s × s); its first row is zero and its last row is b.
    pub a: Vec<f64>,
    /// IIIB matrix Ā (s × s); its first column is b₁ and its last column is zero.
    pub a_bar: Vec<f64>,
    /// `Â_ik`, rows i = 2..s, columns k = 1..s−1 ((s−1) × (s−1)).
    pub a_hat: Vec<f64>,
    /// `B_ki`, the inverse of Â, rows k = 1..s−1, columns i = 2..s ((s−1) × (s−1)).
    pub b_matrix: Vec<f64>,
    /// `w_i = Σ_{k<s} b_k B_ki`, i = 2..s (s−1): the end momentum without the last stage's force is
    /// `p₀ + M Σ_i w_i (Q_i − q₀ − h c_i v₀) / h`.
    pub momentum_weights: Vec<f64>,
    /// `(Ā B)_ji`, rows j = 1..s, columns i = 2..s (s × (s−1)): the velocity at stage j is
    /// `v₀ + Σ_i (Ā B)_ji (Q_i − q₀ − h c_i v₀) / h`.
    pub velocity: Vec<f64>,
    /// Rounding errors of `nodes`, `b_matrix` and `momentum_weights`: the coefficients to twice the digits.
    pub remainders: Remainders,
    /// Row s of the inverse of the matrix `P_k(2c_i − 1)` (rows i, columns k = 0..s−1) (s): applied to values at the
    /// nodes it gives the highest Legendre coefficient of their interpolant, the step-size control's error measure.
    pub top_legendre: Vec<f64>,
}

/// The digits of the coefficients beyond a double; the same shapes as in [`Tableau`].
#[derive(Clone, Debug, PartialEq)]
pub struct Remainders {
    /// Digits beyond `nodes` (s).
    pub nodes: Vec<f64>,
    /// Digits beyond `b_matrix` ((s−1) × (s−1)).
    pub b_matrix: Vec<f64>,
    /// Digits beyond `momentum_weights` (s−1).
    pub momentum_weights: Vec<f64>,
}

/// Why there is no tableau.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableauError {
    /// The number of stages is out of range.
    #[error("{stages} stages: the number of stages must be from {MINIMUM_STAGES} to {MAXIMUM_STAGES}")]
    Stages {
        /// The requested number of stages.
        stages: usize,
    },
}

impl Tableau {
    /// The coefficients for a number of stages from 2 to 16, each correctly rounded but for ties within 1e-28.
    ///
    /// They are worked out once a process, which takes as long as ten seconds of the motion of a double pendulum.
    ///
    /// # Errors
    /// [`TableauError::Stages`] if the number is out of range.
    pub fn of(stages: usize) -> Result<&'static Tableau, TableauError> {
        static KNOWN: [OnceLock<Tableau>; MAXIMUM_STAGES + 1] = [const { OnceLock::new() }; MAXIMUM_STAGES + 1];
        if !(MINIMUM_STAGES..=MAXIMUM_STAGES).contains(&stages) {
            return Err(TableauError::Stages { stages });
        }
        Ok(KNOWN[stages].get_or_init(|| Tableau::rounded(&Exact::new(stages))))
    }

    fn rounded(exact: &Exact) -> Tableau {
        let round = |values: &[Extended]| values.iter().map(|value| value.rounded()).collect();
        let rest = |values: &[Extended]| values.iter().map(|value| value.remainder()).collect();
        Tableau {
            stages: exact.nodes.len(),
            remainders: Remainders {
                nodes: rest(&exact.nodes),
                b_matrix: rest(&exact.b_matrix),
                momentum_weights: rest(&exact.momentum_weights),
            },
            nodes: round(&exact.nodes),
            weights: round(&exact.weights),
            a: round(&exact.a),
            a_bar: round(&exact.a_bar),
            a_hat: round(&exact.a_hat),
            b_matrix: round(&exact.b_matrix),
            momentum_weights: round(&exact.momentum_weights),
            velocity: round(&exact.velocity),
            top_legendre: round(&exact.top_legendre),
        }
    }

    /// Order of convergence of the constrained scheme, 2s − 2 (theorem 2.5.2).
    pub fn order(&self) -> usize {
        2 * self.stages - 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_two_three_and_four_stages_are_the_published_ones() {
        // Hairer, Lubich, Wanner, tables II.1.3 and II.1.4; the same numbers as tables 2.4 to 2.6 of the thesis of T. M. Tyranowski.
        let over =
            |numerators: &[f64], denominator: f64| -> Vec<f64> { numerators.iter().map(|n| n / denominator).collect() };
        let two = Tableau::of(2).unwrap();
        assert_eq!(two.nodes, [0.0, 1.0]);
        assert_eq!(two.weights, [0.5, 0.5]);
        assert_eq!(two.a, [0.0, 0.0, 0.5, 0.5]);
        assert_eq!(two.a_bar, [0.5, 0.0, 0.5, 0.0]);
        assert_eq!((two.a_hat[0], two.b_matrix[0], two.momentum_weights[0]), (0.5, 2.0, 1.0));

        let three = Tableau::of(3).unwrap();
        assert_eq!(three.nodes, [0.0, 0.5, 1.0]);
        assert_eq!(three.weights, over(&[1.0, 4.0, 1.0], 6.0)[..]);
        assert_eq!(three.a, over(&[0.0, 0.0, 0.0, 5.0, 8.0, -1.0, 4.0, 16.0, 4.0], 24.0)[..]);
        assert_eq!(three.a_bar, over(&[1.0, -1.0, 0.0, 1.0, 2.0, 0.0, 1.0, 5.0, 0.0], 6.0)[..]);
        assert_eq!(three.a_hat, over(&[2.0, 1.0, 4.0, 8.0], 24.0)[..]);
        assert_eq!(three.b_matrix, [16.0, -2.0, -8.0, 4.0]);

        let four = Tableau::of(4).unwrap();
        let root = 5f64.sqrt();
        let nodes = [0.0, (5.0 - root) / 10.0, (5.0 + root) / 10.0, 1.0];
        let a = [
            [0.0, 0.0, 0.0, 0.0],
            [11.0 + root, 25.0 - root, 25.0 - 13.0 * root, -1.0 + root],
            [11.0 - root, 25.0 + 13.0 * root, 25.0 + root, -1.0 - root],
            [10.0, 50.0, 50.0, 10.0],
        ];
        let a_bar = [
            [10.0, -5.0 - 5.0 * root, -5.0 + 5.0 * root, 0.0],
            [10.0, 25.0 + root, 25.0 - 13.0 * root, 0.0],
            [10.0, 25.0 + 13.0 * root, 25.0 - root, 0.0],
            [10.0, 55.0 - 5.0 * root, 55.0 + 5.0 * root, 0.0],
        ];
        for i in 0..4 {
            // The right-hand sides are themselves computed in doubles: a few roundings of numbers of size one.
            assert!((four.nodes[i] - nodes[i]).abs() < 1e-15);
            for j in 0..4 {
                assert!((four.a[4 * i + j] - a[i][j] / 120.0).abs() < 1e-15, "A ({i}, {j})");
                assert!((four.a_bar[4 * i + j] - a_bar[i][j] / 120.0).abs() < 1e-15, "second ({i}, {j})");
            }
        }
    }

    #[test]
    fn entries_of_b_are_correctly_rounded() {
        // Computed independently with 60 digits by inverting Â, itself from the Vandermonde system of the nodes.
        let nine = &Tableau::of(9).unwrap().b_matrix;
        assert_eq!(nine[0], 1943.2767947162022);
        assert_eq!(nine[1], -241.3454209431098);
        assert_eq!(nine[7 * 8], -2.4704642097882883);
        assert_eq!(nine.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs())), nine[0]);
        let sixteen = Tableau::of(16).unwrap();
        assert_eq!(sixteen.nodes[1], 0.015215976864891033);
        assert_eq!(sixteen.b_matrix[0], 21338.70013068561);
        assert_eq!(sixteen.b_matrix[14 * 15], 2.127518804361214);
    }

    #[test]
    fn stages_out_of_range_are_refused() {
        for stages in [0, 1, 17] {
            assert_eq!(Tableau::of(stages).err(), Some(TableauError::Stages { stages }));
        }
    }
}

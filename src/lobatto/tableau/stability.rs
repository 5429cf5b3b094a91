//! The limit of stability of the scheme.
//!
//! Applied to `y″ = −ω² y`, a step of length h is a 2 × 2 matrix of determinant 1 with equal diagonal entries
//! `t(h²ω²) = Q_s` for `(y, y′) = (1, 0)`,
//!
//! ```text
//!     Q_i = 1 − h²ω² Σ_{k<s} Â_ik Q_k,   i = 2..s,   Q₁ = 1              stable while |t| ≤ 1
//! ```
//!
//! and beyond that no solver helps: the fastest mode grows by `(hω)²` a step. There are gaps, in which |t| exceeds 1 by so little that a motion
//! leaves them before it grows; the limits pass over gaps below 1 + 10⁻³.
//!
//! A damper of ratio ζ gives `y″ = −ω² y − 2ζω y′`; forces enter at all stages, and the step is stable further than without:
//!
//! ```text
//!     F = −ω² Y − 2ζω V,   V = v₀ + h Ā F,   Y = y₀ + h A V,   y₁ = y₀ + h bᵀV,   v₁ = v₀ + h bᵀF
//! ```
//!
//! while no eigenvalue of `(y₀, v₀) → (y₁, v₁)` exceeds 1 in size; for ζ ≥ ½ up to `(s − 1) √(2s)`, which is where the limit for
//! ζ → ∞ is found to lie, and the least for such ζ within 2·10⁻³ (doc/decisions/007-stability-with-springs-and-dampers.md).

use crate::tableau::butcher::{MAXIMUM_STAGES, Tableau};
use nalgebra::{DMatrix, DVector, Matrix2};
use std::sync::OnceLock;

/// Part of the limit from where a step is near to it.
pub const NEAR: f64 = 0.5;

/// The largest hω up to which steps of 2 … 16 stages are stable. A table, because to find the nine stages' took half of the instructions of a
/// short run; the test below finds all of them anew.
const LIMITS: [f64; MAXIMUM_STAGES - 1] = [
    2.0,
    2.828_427_124_746,
    5.477_225_575_052,
    6.054_049_612_981,
    8.841_474_277_144,
    9.267_346_059_619,
    12.153_145_457_687,
    12.460_979_479_641,
    15.422_567_576_793,
    15.638_352_468_954,
    18.656_610_944_197,
    21.589_891_148_239,
    21.862_695_365_507,
    24.850_194_818_772,
    25.048_060_690_956,
];

/// The largest hω up to which steps of this scheme are stable.
pub fn limit(tableau: &Tableau) -> f64 {
    LIMITS[tableau.stages - 2]
}

/// Damping ratios for which limits are found.
const RATIOS: [f64; 6] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5];

/// The largest hω up to which steps of this scheme are stable for a mode. It is found for the next lower one of some damping ratios, because the
/// limit grows with the ratio up to ½, and only if the mode comes near the limit without damping.
pub fn limit_for(tableau: &Tableau, product: f64, damping: f64) -> f64 {
    static DAMPED_LIMITS: [[OnceLock<f64>; RATIOS.len()]; MAXIMUM_STAGES + 1] =
        [const { [const { OnceLock::new() }; RATIOS.len()] }; MAXIMUM_STAGES + 1];
    let undamped = limit(tableau);
    let Some(ratio) = RATIOS.iter().rposition(|&ratio| ratio <= damping).filter(|_| product > NEAR * undamped) else {
        return undamped;
    };
    *DAMPED_LIMITS[tableau.stages][ratio].get_or_init(|| damped_limit(tableau, RATIOS[ratio]))
}

/// The largest hω up to which steps of this scheme are stable for `y″ = −ω² y − 2ζω y′`; not less than without damping.
pub fn damped_limit(tableau: &Tableau, ratio: f64) -> f64 {
    let undamped = limit(tableau);
    let stages = tableau.stages as f64;
    let hard = (stages - 1.0) * (2.0 * stages).sqrt();
    if ratio >= 0.5 {
        return hard;
    }
    // A shorter unstable range is passed in few steps, and grows by less than the range after it.
    const STRIDE: f64 = 0.05;
    let mut frequency = undamped;
    while frequency < hard && growth(tableau, frequency + STRIDE, ratio) <= 1.0 {
        frequency += STRIDE;
    }
    frequency
}

/// Growth of the solutions of `y″ = −ω² y − 2ζω y′` in one step with h = 1: the spectral radius of the step.
fn growth(tableau: &Tableau, omega: f64, ratio: f64) -> f64 {
    let s = tableau.stages;
    let (stiffness, damping) = (omega * omega, 2.0 * ratio * omega);
    let a = DMatrix::from_row_slice(s, s, &tableau.a);
    let a_bar = DMatrix::from_row_slice(s, s, &tableau.a_bar);
    let weights = DVector::from_column_slice(&tableau.weights);
    let ones = DVector::from_element(s, 1.0);
    let along = &a * &ones;
    let system = (DMatrix::identity(s, s) + &a * &a_bar * stiffness + &a_bar * damping).lu();
    let (Some(by_position), Some(by_velocity)) =
        (system.solve(&(&ones * -stiffness)), system.solve(&(along * -stiffness - &ones * damping)))
    else {
        return f64::INFINITY;
    };
    let step = Matrix2::new(
        1.0 + weights.dot(&(&a_bar * &by_position)),
        1.0 + weights.dot(&(&a_bar * &by_velocity)),
        weights.dot(&by_position),
        1.0 + weights.dot(&by_velocity),
    );
    step.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Excess of |t| over 1 that is passed over.
    const GAP: f64 = 1e-3;
    /// Gaps that are more than passed over are wider than this.
    const STRIDE: f64 = 0.02;

    /// Half the trace of the step for `y″ = −ω² y`, as a function of hω.
    fn half_trace(tableau: &Tableau, frequency: f64) -> f64 {
        let inner = tableau.stages - 1;
        let square = frequency * frequency;
        let entry = |i: usize, k: usize| square * tableau.a_hat[i * inner + k];
        // The unknowns are Q_2 … Q_{s−1}: rows 0 … s−3 of Â, whose columns 1 … s−2 belong to them.
        let unknowns = inner - 1;
        if unknowns == 0 {
            return 1.0 - entry(0, 0);
        }
        let matrix = DMatrix::from_fn(unknowns, unknowns, |i, k| if i == k { 1.0 } else { 0.0 } + entry(i, k + 1));
        let right = DVector::from_fn(unknowns, |i, _| 1.0 - entry(i, 0));
        let stages = matrix.lu().solve(&right).expect("regular below the limit");
        1.0 - entry(unknowns, 0) - (0..unknowns).map(|k| entry(unknowns, k + 1) * stages[k]).sum::<f64>()
    }

    #[test]
    fn the_table_of_limits_is_where_the_trace_of_a_step_leaves_one() {
        for stages in 2..=MAXIMUM_STAGES {
            let tableau = Tableau::of(stages).expect("in range");
            let excess = |frequency: f64| half_trace(tableau, frequency).abs() - 1.0;
            let (mut low, mut frequency) = (0.0, 0.0);
            while excess(frequency) <= GAP {
                if excess(frequency) <= 0.0 {
                    low = frequency;
                }
                frequency += STRIDE;
            }
            let mut high = low + STRIDE;
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                *(if excess(middle) <= 0.0 { &mut low } else { &mut high }) = middle;
            }
            // The digits of the table.
            assert!((limit(tableau) - low).abs() < 1e-11, "{stages} stages: {low:?}");
        }
    }
}

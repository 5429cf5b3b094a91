//! Dense output: the motion inside a step, from the collocation polynomial.
//!
//! Each joint displacement is interpolated by the polynomial that meets it at all nodes and has the step's velocities
//! at both ends; poses rebuilt from it satisfy every joint to rounding. With the interpolant `L` of the nodes alone
//! and `ω(x) = Π (x − c_i)`,
//!
//! ```text
//!     p(x) = L(x) + ω(x) (α + β x),    α = (h v₀ − L'(0)) / ω'(0),    α + β = (h v₁ − L'(1)) / ω'(1)
//! ```

use super::tableau::Tableau;

/// The interpolation rule of a tableau at one point of the step: all that is linear in the data.
#[derive(Clone, Debug)]
pub struct DenseRule {
    nodes: Vec<f64>,
    /// Differentiation rows of the nodal interpolant at both ends.
    derivative_at_start: Vec<f64>,
    derivative_at_end: Vec<f64>,
    /// ω' at both ends.
    slope_at_start: f64,
    slope_at_end: f64,
}

/// Values and slopes at one point as linear combinations of nodal displacements and end velocities.
#[derive(Clone, Debug, Default)]
pub struct DenseWeights {
    value: Vec<f64>,
    slope: Vec<f64>,
    /// Weights of `h v₀` and `h v₁` in the value and in the slope.
    value_ends: [f64; 2],
    slope_ends: [f64; 2],
}

impl DenseRule {
    /// The rule of a scheme.
    pub fn new(tableau: &Tableau) -> Self {
        let nodes = tableau.nodes.clone();
        let count = nodes.len();
        let derivative_at_start = lagrange(&nodes, 0.0).1;
        let derivative_at_end = lagrange(&nodes, 1.0).1;
        let slope = |at: usize| (0..count).filter(|&k| k != at).map(|k| nodes[at] - nodes[k]).product();
        let (slope_at_start, slope_at_end) = (slope(0), slope(count - 1));
        DenseRule { nodes, derivative_at_start, derivative_at_end, slope_at_start, slope_at_end }
    }

    /// The weights for the point `x` of the step, from 0 to 1.
    pub fn weights(&self, x: f64) -> DenseWeights {
        let (mut value, mut slope) = lagrange(&self.nodes, x);
        let omega: f64 = self.nodes.iter().map(|node| x - node).product();
        let omega_slope: f64 = (0..self.nodes.len())
            .map(|skip| {
                self.nodes.iter().enumerate().filter(|(k, _)| *k != skip).map(|(_, node)| x - node).product::<f64>()
            })
            .sum();
        // p = L + ω (1 − x) a₀ + ω x a₁ with a₀ = (h v₀ − L'(0))/ω'(0) and a₁ = (h v₁ − L'(1))/ω'(1).
        let start = [omega * (1.0 - x), omega_slope * (1.0 - x) - omega].map(|factor| factor / self.slope_at_start);
        let end = [omega * x, omega_slope * x + omega].map(|factor| factor / self.slope_at_end);
        for k in 0..self.nodes.len() {
            value[k] -= start[0] * self.derivative_at_start[k] + end[0] * self.derivative_at_end[k];
            slope[k] -= start[1] * self.derivative_at_start[k] + end[1] * self.derivative_at_end[k];
        }
        DenseWeights { value, slope, value_ends: [start[0], end[0]], slope_ends: [start[1], end[1]] }
    }
}

impl DenseWeights {
    /// Displacement and its derivative by x, from the displacements at nodes 2 … s and `h v` at both ends.
    pub fn apply(&self, stages: &[f64], start: f64, end: f64) -> (f64, f64) {
        let dot = |weights: &[f64]| weights[1..].iter().zip(stages).map(|(weight, value)| weight * value).sum::<f64>();
        (
            dot(&self.value) + self.value_ends[0] * start + self.value_ends[1] * end,
            dot(&self.slope) + self.slope_ends[0] * start + self.slope_ends[1] * end,
        )
    }
}

/// Lagrange polynomials of the nodes at `x`: values and first derivatives.
fn lagrange(nodes: &[f64], x: f64) -> (Vec<f64>, Vec<f64>) {
    let count = nodes.len();
    let mut values = vec![0.0; count];
    let mut slopes = vec![0.0; count];
    for j in 0..count {
        let others = || (0..count).filter(move |&k| k != j);
        let scale: f64 = others().map(|k| nodes[j] - nodes[k]).product();
        values[j] = others().map(|k| x - nodes[k]).product::<f64>() / scale;
        slopes[j] =
            others().map(|skip| others().filter(|&k| k != skip).map(|k| x - nodes[k]).product::<f64>()).sum::<f64>()
                / scale;
    }
    (values, slopes)
}

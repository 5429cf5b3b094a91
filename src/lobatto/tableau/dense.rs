//! Dense output: the motion inside a step, from the collocation polynomial.
//!
//! Each joint displacement is interpolated by the polynomial that meets it at all nodes and has the step's velocities at both ends; poses rebuilt
//! from it satisfy every joint to rounding. Let `L` be the interpolant of the nodes alone and `ω(x) = Π (x − c_i)`:
//!
//! ```text
//!     p(x) = L(x) + ω(x) (α + β x),    α = (h v₀ − L'(0)) / ω'(0),    α + β = (h v₁ − L'(1)) / ω'(1)
//! ```
//!
//! The velocities at the ends add a part of degree `s` and one of degree `s + 1`. How large they are anywhere in the step tells how fast the
//! coefficients of the motion fall, and whether the velocities belong to it:
//!
//! ```text
//!     ω (α + β x) = (α + β/2) ω + β ω (x − ½),    S = |α + β/2| max |ω|,    B = |β| max |ω (x − ½)|
//! ```

use crate::numbers::lanes::MAX_LANES;
use crate::tableau::butcher::Tableau;

/// The first stage has no lane.
const MAX_STAGES: usize = MAX_LANES + 1;

/// The interpolation rule of a tableau: all that does not depend on the point of the step.
#[derive(Clone, Debug)]
pub struct DenseRule {
    nodes: Vec<f64>,
    /// Product of the distances of each node from the others.
    scales: Vec<f64>,
    /// Differentiation rows of the nodal interpolant at both ends.
    derivative_at_start: Vec<f64>,
    derivative_at_end: Vec<f64>,
    /// ω' at both ends.
    slope_at_start: f64,
    slope_at_end: f64,
    /// `max |ω|` and `max |ω (x − ½)|`.
    reach: [f64; 2],
}

/// Number of points of a step that are searched for the largest `|ω|`, which is flat there.
const POINTS: usize = 64;

/// Values and slopes at one point as linear combinations of nodal displacements and end velocities.
#[derive(Clone, Copy, Debug, Default)]
pub struct DenseWeights {
    value: [f64; MAX_STAGES],
    slope: [f64; MAX_STAGES],
    /// Weights of `h v₀` and `h v₁` in the value and in the slope.
    value_ends: [f64; 2],
    slope_ends: [f64; 2],
}

impl DenseRule {
    /// The rule of a scheme.
    pub fn new(tableau: &Tableau) -> Self {
        let nodes = tableau.nodes.clone();
        let (count, scales) = (nodes.len(), scales(&nodes));
        let slopes = |x: f64| nodal(&nodes, &scales, x).slopes[..count].to_vec();
        let (derivative_at_start, derivative_at_end) = (slopes(0.0), slopes(1.0));
        let (slope_at_start, slope_at_end) = (scales[0], scales[count - 1]);
        let omega = |x: f64| nodes.iter().map(|node| x - node).product::<f64>();
        let points = (1..POINTS).map(|point| point as f64 / POINTS as f64);
        let reach = points.fold([0.0_f64; 2], |[even, odd], x| {
            let omega = omega(x).abs();
            [even.max(omega), odd.max(omega * (x - 0.5).abs())]
        });
        DenseRule { nodes, scales, derivative_at_start, derivative_at_end, slope_at_start, slope_at_end, reach }
    }

    /// Weights of the displacements at the nodes 2 … s, of which there are `inner`, in L'(0) and in L'(1).
    pub fn end_slopes(&self, inner: usize) -> [&[f64]; 2] {
        [&self.derivative_at_start[1..=inner], &self.derivative_at_end[1..=inner]]
    }

    /// `S` and `B`, for L'(0), L'(1) and `h v` at both ends.
    pub fn additions(&self, [first, last]: [f64; 2], start: f64, end: f64) -> [f64; 2] {
        let first = (start - first) / self.slope_at_start;
        let last = (end - last) / self.slope_at_end;
        [self.reach[0] * (0.5 * (first + last)).abs(), self.reach[1] * (last - first).abs()]
    }

    /// The weights for the point `x` in the polynomial `L` through the nodes alone. Does not allocate.
    pub fn weights_of_nodes(&self, x: f64) -> DenseWeights {
        let Nodal { values, slopes, .. } = nodal(&self.nodes, &self.scales, x);
        DenseWeights { value: values, slope: slopes, ..DenseWeights::default() }
    }

    /// The weights for the point `x` of the step, from 0 to 1. Does not allocate.
    pub fn weights(&self, x: f64) -> DenseWeights {
        let Nodal { values: mut value, slopes: mut slope, omega: (omega, omega_slope) } =
            nodal(&self.nodes, &self.scales, x);
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
    /// The weights of the displacements at the nodes 2 … s, of which there are `inner`, in the value and in the slope.
    pub fn of_stages(&self, inner: usize) -> [&[f64]; 2] {
        [&self.value[1..=inner], &self.slope[1..=inner]]
    }

    /// Displacement and its derivative by x, from both sums over the nodes and `h v` at both ends.
    pub fn apply(&self, [value, slope]: [f64; 2], start: f64, end: f64) -> (f64, f64) {
        (
            value + self.value_ends[0] * start + self.value_ends[1] * end,
            slope + self.slope_ends[0] * start + self.slope_ends[1] * end,
        )
    }
}

/// The product of the distances of each node from all others.
pub(crate) fn scales(nodes: &[f64]) -> Vec<f64> {
    let scale = |j: usize| (0..nodes.len()).filter(|&k| k != j).map(|k| nodes[j] - nodes[k]).product();
    (0..nodes.len()).map(scale).collect()
}

/// The nodal polynomials at a point.
#[derive(Clone)]
struct Nodal {
    /// Lagrange polynomials and their first derivatives.
    values: [f64; MAX_STAGES],
    slopes: [f64; MAX_STAGES],
    /// ω and ω'.
    omega: (f64, f64),
}

/// The nodal polynomials at `x`. The numbers of stages of chosen steps are known at compile time, with the same bits.
fn nodal(nodes: &[f64], scales: &[f64], x: f64) -> Nodal {
    match (<&[f64; 5]>::try_from(nodes), <&[f64; 9]>::try_from(nodes)) {
        (Ok(five), _) => nodal_at(five, scales, x),
        (_, Ok(nine)) => nodal_at(nine, scales, x),
        _ => nodal_at(nodes, scales, x),
    }
}

/// The nodal polynomials of these nodes at `x`.
///
/// All products of differences are taken from the first node to the last; products up to a node that is left out are shared by all sums that leave it
/// out.
#[inline(always)]
fn nodal_at(nodes: &(impl AsRef<[f64]> + ?Sized), scales: &[f64], x: f64) -> Nodal {
    let nodes = nodes.as_ref();
    let count = nodes.len();
    let mut distances = [0.0; MAX_STAGES];
    for (distance, node) in distances.iter_mut().zip(nodes) {
        *distance = x - node;
    }
    let distances = &distances[..count];
    let (mut values, mut slopes) = ([0.0; MAX_STAGES], [0.0; MAX_STAGES]);
    let (mut before, mut omega_slope) = (1.0, 0.0);
    let mut j = 0;
    while j < count {
        let left = rest(before, distances, j + 1);
        values[j] = left / scales[j];
        omega_slope += left;
        // Leaving out a pair of nodes counts for the slopes of both.
        let mut between = before;
        let mut k = j + 1;
        while k < count {
            let left = rest(between, distances, k + 1);
            slopes[j] += left;
            slopes[k] += left;
            between *= distances[k];
            k += 1;
        }
        before *= distances[j];
        j += 1;
    }
    for (slope, scale) in slopes.iter_mut().zip(scales) {
        *slope /= scale;
    }
    Nodal { values, slopes, omega: (before, omega_slope) }
}

/// A product, times the distances from one on.
#[inline(always)]
fn rest(start: f64, distances: &[f64], from: usize) -> f64 {
    let (mut product, mut index) = (start, from);
    while index < distances.len() {
        product *= distances[index];
        index += 1;
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The displacements of `f` at the nodes 2 … s, with f(0) = 0.
    fn at_nodes(tableau: &Tableau, f: impl Fn(f64) -> f64) -> Vec<f64> {
        tableau.nodes[1..].iter().map(|&node| f(node)).collect()
    }

    fn sum(weights: &[f64], values: &[f64]) -> f64 {
        weights.iter().zip(values).map(|(weight, value)| weight * value).sum()
    }

    #[test]
    fn what_the_velocities_add_is_found_by_degree_and_is_the_difference_of_the_two_polynomials() {
        for stages in [2, 5, 9] {
            let tableau = Tableau::of(stages).unwrap();
            let rule = DenseRule::new(tableau);
            let omega = |x: f64| tableau.nodes.iter().map(|node| x - node).product::<f64>();
            let slope = |f: &dyn Fn(f64) -> f64, x: f64| (f(x + 1e-5) - f(x - 1e-5)) / 2e-5;
            // A polynomial that the nodes know, and parts of degree s and s + 1 beside it.
            for [even, odd] in [[0.0, 0.0], [3.0, 0.0], [0.0, -2.0]] {
                let f = |x: f64| 0.7 * x + omega(x) * (even + odd * (x - 0.5));
                let values = at_nodes(tableau, f);
                let slopes = rule.end_slopes(stages - 1).map(|weights| sum(weights, &values));
                let ends = [slope(&f, 0.0), slope(&f, 1.0)];
                let found = rule.additions(slopes, ends[0], ends[1]);
                let largest = |part: &dyn Fn(f64) -> f64| {
                    (0..=1000).map(|point| part(point as f64 / 1000.0).abs()).fold(0.0, f64::max)
                };
                let expected = [largest(&|x| even * omega(x)), largest(&|x| odd * omega(x) * (x - 0.5))];
                let size = largest(&omega);
                for (found, expected) in found.into_iter().zip(expected) {
                    // Differences of 2e-5 have an error of 1e-10, and the largest of 64 points is flat to a hundredth.
                    assert!((found - expected).abs() <= 0.01 * expected + 1e-6 * size, "{stages}: {found}, {expected}");
                }
                for point in 0..=10 {
                    let x = f64::from(point) / 10.0;
                    let at = |weights: &DenseWeights| {
                        let [value, slope] = weights.of_stages(stages - 1).map(|weights| sum(weights, &values));
                        weights.apply([value, slope], ends[0], ends[1])
                    };
                    let (nodes, both) = (at(&rule.weights_of_nodes(x)), at(&rule.weights(x)));
                    assert!((nodes.0 - 0.7 * x).abs() < 1e-13, "{stages}, {x}: {nodes:?}");
                    assert!((nodes.1 - 0.7).abs() < 1e-12, "{stages}, {x}: {nodes:?}");
                    assert!((both.0 - f(x)).abs() < 1e-6 * size + 1e-13, "{stages}, {x}: {both:?}, not {}", f(x));
                }
            }
        }
    }
}

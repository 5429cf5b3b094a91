//! Anderson acceleration of the stage iteration.
//!
//! Let `x_n` be the iterates, `f_n = G(x_n) − x_n` their increments, and ΔX, ΔF the differences of the last m iterations:
//!
//! ```text
//!     γ = argmin | f_n − ΔF γ |,      x_{n+1} = x_n + f_n − (ΔX + ΔF) γ
//! ```
//!
//! over all degrees of freedom and stages together. Source: D. Anderson, J. ACM 12 (1965); H. Walker and P. Ni, SIAM
//! J. Numer. Anal. 49 (2011). Depth 3 is enough here (doc/decisions/003-simplified-newton-iteration.md).

use crate::numbers::lanes::Lanes;

/// Number of past differences in use.
const DEPTH: usize = 3;

/// One past difference of a degree of freedom, or its last values.
#[derive(Clone, Copy)]
struct History<V> {
    increment: V,
    target: V,
    increments: [V; DEPTH],
    targets: [V; DEPTH],
}

/// The memory of the acceleration within one step.
#[derive(Clone)]
pub struct Anderson<V> {
    history: Vec<History<V>>,
    gram: [[f64; DEPTH]; DEPTH],
    iterations: usize,
}

impl<V: Lanes> Anderson<V> {
    /// Memory for a number of unknowns.
    pub fn new(unknowns: usize) -> Self {
        let zero = V::zero();
        let empty = History { increment: zero, target: zero, increments: [zero; DEPTH], targets: [zero; DEPTH] };
        Anderson { history: vec![empty; unknowns], gram: [[0.0; DEPTH]; DEPTH], iterations: 0 }
    }

    /// Forgets everything: a new system of equations.
    pub fn restart(&mut self) {
        self.iterations = 0;
        self.gram = [[0.0; DEPTH]; DEPTH];
    }

    /// Replaces the iterate `x` by the next one, `f` being its increment; returns the largest |x| of each lane.
    #[inline(always)]
    pub fn advance(&mut self, x: &mut [V], f: &[V]) -> V {
        let mut largest = V::zero();
        if self.iterations == 0 {
            for ((x, &f), memory) in x.iter_mut().zip(f).zip(&mut self.history) {
                *x = *x + f;
                *memory =
                    History { increment: f, target: *x, increments: [V::zero(); DEPTH], targets: [V::zero(); DEPTH] };
                largest = x.max_abs(largest);
            }
            self.iterations = 1;
            return largest;
        }
        let newest = (self.iterations - 1) % DEPTH;
        let (mut dots0, mut dots1, mut dots2) = (V::zero(), V::zero(), V::zero());
        let (mut right0, mut right1, mut right2) = (V::zero(), V::zero(), V::zero());
        for ((x, &f), memory) in x.iter().zip(f).zip(&mut self.history) {
            let target = *x + f;
            let difference = f - memory.increment;
            memory.increments[newest] = difference;
            memory.targets[newest] = target - memory.target;
            memory.increment = f;
            memory.target = target;
            let [a, b, c] = memory.increments;
            dots0 = difference.mul_add(a, dots0);
            dots1 = difference.mul_add(b, dots1);
            dots2 = difference.mul_add(c, dots2);
            right0 = f.mul_add(a, right0);
            right1 = f.mul_add(b, right1);
            right2 = f.mul_add(c, right2);
        }
        let dots = [dots0.sum(), dots1.sum(), dots2.sum()];
        for (column, dot) in dots.into_iter().enumerate() {
            self.gram[newest][column] = dot;
            self.gram[column][newest] = dot;
        }
        let gamma = solve(&self.gram, [right0.sum(), right1.sum(), right2.sum()], newest);
        let [first, second, third] = gamma;
        let (first, second, third) = (V::splat(first), V::splat(second), V::splat(third));
        for (x, memory) in x.iter_mut().zip(&self.history) {
            let [a, b, c] = memory.targets;
            *x = third.neg_mul_add(c, second.neg_mul_add(b, first.neg_mul_add(a, memory.target)));
            largest = x.max_abs(largest);
        }
        self.iterations += 1;
        largest
    }
}

/// Solves the normal equations, eliminating the newest difference first and leaving out differences that the newer ones already span to rounding.
fn solve(gram: &[[f64; DEPTH]; DEPTH], right: [f64; DEPTH], newest: usize) -> [f64; DEPTH] {
    let order: [usize; DEPTH] = [newest, (newest + DEPTH - 1) % DEPTH, (newest + DEPTH - 2) % DEPTH];
    let mut matrix = [[0.0; DEPTH]; DEPTH];
    let mut value = [0.0; DEPTH];
    for row in 0..DEPTH {
        value[row] = right[order[row]];
        for column in 0..DEPTH {
            matrix[row][column] = gram[order[row]][order[column]];
        }
    }
    // One over each pivot, or zero where the difference is a combination of the newer ones to rounding: its
    // coefficient would be noise.
    let mut inverse = [0.0; DEPTH];
    for pivot in 0..DEPTH {
        let size = gram[order[pivot]][order[pivot]];
        if matrix[pivot][pivot] <= 1e-13 * size || !size.is_normal() {
            continue;
        }
        inverse[pivot] = 1.0 / matrix[pivot][pivot];
        for row in pivot + 1..DEPTH {
            let factor = matrix[row][pivot] * inverse[pivot];
            for column in pivot..DEPTH {
                matrix[row][column] -= factor * matrix[pivot][column];
            }
            value[row] -= factor * value[pivot];
        }
    }
    let mut gamma = [0.0; DEPTH];
    for pivot in (0..DEPTH).rev() {
        let known: f64 = (pivot + 1..DEPTH).map(|column| matrix[pivot][column] * gamma[order[column]]).sum();
        gamma[order[pivot]] = (value[pivot] - known) * inverse[pivot];
    }
    gamma
}

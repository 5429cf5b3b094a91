//! The way out where Newton's method stalls: a sequence of convex problems, each with a friction cone that is shifted by the last slip.
//!
//! ```text
//!     min ½|v − v_f|²_M̃ + Σ ε/(2ρ) |Π_K(r₀ − (ρ/ε)(u + s n))|²          Newton with the derivative of the projection, exact line search
//!     r ← Π_K(…),   s ← μ|u_T|,   ε: 1e-3, then a tenth of it each round down to 1e-6
//! ```
//!
//! A motor has its own compliance c in the place of ε/ρ, without r₀. After each round Newton's method of `newton.rs` tries to finish.
//!
//! Source: R. T. Rockafellar, Augmented Lagrangians and the proximal point algorithm (1976); G. De Saxcé, Z.-Q. Feng (1998) for the shift.

use crate::newton::{Workspace, newton};
use crate::problem::Problem;
use nalgebra::Vector3;

/// The residual at which an island counts as solved, and the one at which the last rounds stop.
pub const TOLERANCE: f64 = 5e-9;
const ENOUGH: f64 = 1e-7;
/// Blocks are added this often at most.
const WIDENED: usize = 8;
/// Iterations of Newton's method at first, after a round, and of one convex problem.
const NEWTON: f64 = 30.0;
const AFTER: f64 = 8.0;
const CONVEX: usize = 20;
const ROUNDS: usize = 12;
/// The proximal part of the first round, and the least one.
const FIRST: f64 = 1e-3;
const LEAST: f64 = 1e-6;
/// The slope at which a line search ends, as a part of the first, and its most evaluations.
const FLAT: f64 = 0.1;
const SEARCHES: usize = 12;
/// A convex problem is solved when the decrement of Newton's method is this part of the first.
const SOLVED: f64 = 1e-4;

/// Solves the problem of an island from these impulses; returns its residual. Blocks that exert no impulse and do not close are left out, until
/// the others make them close: hundreds of points of a hull are near a floor, and few of them press.
pub fn solve(problem: &mut Problem, impulses: &mut [Vector3<f64>], v: &mut Vec<f64>, room: &mut Workspace) -> f64 {
    let all = std::mem::take(&mut problem.blocks);
    let mut part: Vec<usize> = (0..all.len())
        .filter(|&number| impulses[number] != Vector3::zeros() || problem.is_called(&all[number], &problem.free))
        .collect();
    let mut residual = 0.0;
    for _ in 0..WIDENED {
        problem.blocks.clear();
        problem.blocks.extend(part.iter().map(|&number| all[number]));
        let mut own: Vec<Vector3<f64>> = part.iter().map(|&number| impulses[number]).collect();
        residual = solve_all(problem, &mut own, v, room);
        part.iter().zip(own).for_each(|(&number, impulse)| impulses[number] = impulse);
        let before = part.len();
        let mut inside = part.iter().copied().peekable();
        let others = (0..all.len()).filter(|number| inside.next_if_eq(number).is_none());
        let more: Vec<usize> = others.filter(|&number| problem.is_called(&all[number], v)).collect();
        part.extend(more);
        part.sort_unstable();
        if part.len() == before {
            break;
        }
    }
    problem.blocks = all;
    residual
}

/// The same with all blocks.
fn solve_all(problem: &Problem, impulses: &mut [Vector3<f64>], v: &mut Vec<f64>, room: &mut Workspace) -> f64 {
    let mut residual = newton(problem, impulses, v, [TOLERANCE, NEWTON], room);
    if residual <= TOLERANCE || impulses.is_empty() {
        return residual;
    }
    let (mut best, mut rates) = (impulses.to_vec(), Vec::new());
    let mut shifts: Vec<f64> = (0..impulses.len()).map(|number| shift(problem, number, v)).collect();
    let mut own = impulses.to_vec();
    for round in 0..ROUNDS {
        let proximal = (FIRST * 0.1_f64.powi(round as i32)).max(LEAST);
        convex(problem, &mut own, &shifts, v, proximal, room);
        for (number, before) in shifts.iter_mut().enumerate() {
            let now = shift(problem, number, v);
            *before = if round > ROUNDS / 2 { 0.5 * (*before + now) } else { now };
        }
        let mut tried = own.clone();
        let found = newton(problem, &mut tried, &mut rates, [TOLERANCE, AFTER], room);
        if found < residual {
            (residual, best) = (found, tried);
        }
        if residual <= TOLERANCE || (round + 1 >= ROUNDS / 2 && residual <= ENOUGH) {
            break;
        }
    }
    impulses.copy_from_slice(&best);
    problem.velocity(impulses, v);
    residual
}

fn shift(problem: &Problem, number: usize, v: &[f64]) -> f64 {
    problem.blocks[number].law.shift(&problem.rate(number, v, &Vector3::zeros()))
}

/// The penalty of a convex problem.
struct Penalty<'p> {
    problem: &'p Problem<'p>,
    start: Vec<Vector3<f64>>,
    shifts: &'p [f64],
    proximal: f64,
}

impl Penalty<'_> {
    /// Impulse over rate of a block [N s/(m/s)].
    fn stiffness(&self, number: usize) -> f64 {
        let block = &self.problem.blocks[number];
        if block.compliance > 0.0 { 1.0 / block.compliance } else { block.rho / self.proximal }
    }

    /// The argument of the projection.
    fn argument(&self, number: usize, v: &[f64]) -> Vector3<f64> {
        let block = &self.problem.blocks[number];
        let mut rate = self.problem.moved(number, v) + block.bias;
        rate.x += self.shifts[number];
        let start = if block.compliance > 0.0 { Vector3::zeros() } else { self.start[number] };
        start - rate * self.stiffness(number)
    }

    /// Impulses at these rates, and the gradient of the function.
    fn evaluate(&self, v: &[f64], impulses: &mut [Vector3<f64>], gradient: &mut Vec<f64>) {
        gradient.clear();
        gradient.resize(v.len(), 0.0);
        for (number, impulse) in impulses.iter_mut().enumerate() {
            *impulse = self.problem.blocks[number].law.project(&self.argument(number, v));
            if *impulse != Vector3::zeros() {
                self.problem.spread(number, &-*impulse, gradient);
            }
        }
        self.problem.add_inertia(v, gradient);
    }
}

/// Solves one convex problem; the impulses become the projections.
fn convex(
    problem: &Problem,
    impulses: &mut [Vector3<f64>],
    shifts: &[f64],
    v: &mut Vec<f64>,
    proximal: f64,
    room: &mut Workspace,
) {
    let penalty = Penalty { problem, start: impulses.to_vec(), shifts, proximal };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (mut gradient, mut trial) = (Vec::new(), v.clone());
    let mut first = 0.0;
    for iteration in 0..CONVEX {
        penalty.evaluate(v, impulses, &mut gradient);
        room.iterations += 1;
        problem.begin_matrix(&mut room.factors);
        for number in 0..impulses.len() {
            if let Some(slope) = problem.blocks[number].law.projection_slope(&penalty.argument(number, v)) {
                problem.add_to_matrix(number, &(slope * penalty.stiffness(number)), &mut room.factors);
            }
        }
        room.factors.factor(&problem.pattern);
        let mut direction: Vec<f64> = gradient.iter().map(|entry| -entry).collect();
        room.factors.solve(&problem.pattern, &mut direction);
        let slope = dot(&gradient, &direction);
        if iteration == 0 {
            first = slope.abs();
        }
        if slope >= 0.0 || slope.is_nan() || slope.abs() <= SOLVED * first {
            break;
        }
        // The root of the slope along the direction, which never falls.
        let (mut low, mut high) = ((0.0, slope), (1.0, 0.0));
        let mut part = 1.0;
        for evaluation in 0..SEARCHES {
            trial.clear();
            trial.extend(v.iter().zip(&direction).map(|(v, d)| v + part * d));
            penalty.evaluate(&trial, impulses, &mut gradient);
            let here = dot(&gradient, &direction);
            if (here <= 0.0 && evaluation == 0) || here.abs() <= FLAT * slope.abs() {
                break;
            }
            if here > 0.0 {
                high = (part, here);
            } else {
                low = (part, here);
            }
            part = if evaluation % 3 == 2 {
                0.5 * (low.0 + high.0)
            } else {
                low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1)
            };
        }
        std::mem::swap(v, &mut trial);
    }
    penalty.evaluate(v, impulses, &mut gradient);
}

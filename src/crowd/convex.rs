//! A sequence of convex problems, each with friction cones that are shifted by the last slip: the last way to solve an island.
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

/// Iterations of Newton's method after a round, and of one convex problem.
const AFTER: f64 = 8.0;
const CONVEX: usize = 20;
const ROUNDS: usize = 12;
/// The rounds end if this many of them have not made the residual smaller by this factor, or one of them if it is below [`ENOUGH`]. Before this number
/// of rounds the proximal part is too large for an answer.
const STALLED: usize = 3;
const HALVED: f64 = 0.5;
const LEAST_ROUNDS: usize = 4;
const ENOUGH: f64 = 1e-7;
/// The proximal part of the first round, and the least one.
const FIRST: f64 = 1e-3;
const LEAST: f64 = 1e-6;
/// The slope at which a line search ends, as a part of the first, and its most evaluations.
const FLAT: f64 = 0.1;
const SEARCHES: usize = 12;
/// A convex problem is solved when the decrement of Newton's method is this part of the first.
const SOLVED: f64 = 1e-4;

/// The convex problems, from impulses to better ones with a smaller residual, if there are any.
pub(crate) fn rounds(
    problem: &Problem,
    impulses: &[Vector3<f64>],
    (residual, best): (&mut f64, &mut Vec<Vector3<f64>>),
    v: &mut [f64],
    tolerance: f64,
    room: &mut Workspace,
) {
    let mut rates = Vec::new();
    let mut shifts: Vec<f64> = (0..impulses.len()).map(|number| shift(problem, number, v)).collect();
    let mut own = impulses.to_vec();
    let mut stalled = 0;
    for round in 0..ROUNDS {
        let proximal = (FIRST * 0.1_f64.powi(round as i32)).max(LEAST);
        convex(problem, &mut own, &shifts, v, proximal, room);
        for (number, before) in shifts.iter_mut().enumerate() {
            let now = shift(problem, number, v);
            *before = if round > ROUNDS / 2 { 0.5 * (*before + now) } else { now };
        }
        let mut tried = own.clone();
        let found = newton(problem, &mut tried, &mut rates, [tolerance, AFTER], room);
        stalled = if found < HALVED * *residual { 0 } else { stalled + 1 };
        if found < *residual {
            (*residual, *best) = (found, tried);
        }
        let most = if *residual <= ENOUGH { 1 } else { STALLED };
        if *residual <= tolerance || (round + 1 >= LEAST_ROUNDS && stalled >= most) || room.is_interrupted() {
            break;
        }
    }
}

fn shift(problem: &Problem, number: usize, v: &[f64]) -> f64 {
    problem.blocks[number].law.shift(&problem.rate(number, v, &Vector3::zeros()))
}

/// A convex problem: the start of its impulses r₀, its shifts s and its proximal part ε.
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

    /// The argument of the projection, with rates H v.
    fn argument(&self, number: usize, moved: &Vector3<f64>) -> Vector3<f64> {
        let block = &self.problem.blocks[number];
        let mut rate = moved + block.bias;
        rate.x += self.shifts[number];
        let start = if block.compliance > 0.0 { Vector3::zeros() } else { self.start[number] };
        start - rate * self.stiffness(number)
    }

    /// The impulse of a block with rates H v.
    fn impulse(&self, number: usize, moved: &Vector3<f64>) -> Vector3<f64> {
        self.problem.blocks[number].law.project(&self.argument(number, moved))
    }
}

/// Solves one convex problem; the impulses become the projections.
fn convex(
    problem: &Problem,
    impulses: &mut [Vector3<f64>],
    shifts: &[f64],
    v: &mut [f64],
    proximal: f64,
    room: &mut Workspace,
) {
    let penalty = Penalty { problem, start: impulses.to_vec(), shifts, proximal };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let Workspace { factors, iterations, direction, rates, turned, .. } = room;
    let (mut gradient, mut inertia) = (Vec::new(), Vec::new());
    let mut first = 0.0;
    for iteration in 0..=CONVEX {
        rates.clear();
        rates.extend((0..impulses.len()).map(|number| problem.moved(number, v)));
        gradient.clear();
        gradient.resize(v.len(), 0.0);
        problem.add_inertia(v, &mut gradient);
        for (number, (impulse, moved)) in impulses.iter_mut().zip(&*rates).enumerate() {
            *impulse = penalty.impulse(number, moved);
            if *impulse != Vector3::zeros() {
                problem.spread(number, &-*impulse, &mut gradient);
            }
        }
        if iteration == CONVEX {
            break;
        }
        *iterations += 1;
        problem.begin_matrix(factors);
        for (number, moved) in rates.iter().enumerate() {
            if let Some(slope) = problem.blocks[number].law.projection_slope(&penalty.argument(number, moved)) {
                let stiffness = penalty.stiffness(number);
                problem.add_to_matrix(number, &slope.map(|row| row.map(|entry| entry * stiffness)), factors);
            }
        }
        factors.factor(&problem.pattern);
        direction.clear();
        direction.extend(gradient.iter().map(|entry| -entry));
        factors.solve(&problem.pattern, direction);
        let slope = dot(&gradient, direction);
        if iteration == 0 {
            first = slope.abs();
        }
        if slope >= 0.0 || slope.is_nan() || slope.abs() <= SOLVED * first {
            break;
        }
        // The slope along the direction d: d·M̃(v − v_f) + part d·M̃ d − Σ (H d)·r, which never falls. Its root.
        turned.clear();
        turned.extend((0..impulses.len()).map(|number| problem.moved(number, direction)));
        let against: f64 = impulses.iter().zip(&*turned).map(|(impulse, turn)| impulse.dot(turn)).sum();
        inertia.clear();
        inertia.resize(v.len(), 0.0);
        problem.multiply_inertia(direction, &mut inertia);
        let (rest, bend) = (slope + against, dot(direction, &inertia));
        let slope_at = |part: f64| {
            let pushed = rates.iter().zip(&*turned).enumerate();
            let along = |(number, (rate, turn)): (usize, (&Vector3<f64>, &Vector3<f64>))| {
                penalty.impulse(number, &(rate + turn * part)).dot(turn)
            };
            rest + part * bend - pushed.map(along).sum::<f64>()
        };
        let (mut low, mut high) = ((0.0, slope), (1.0, 0.0));
        let mut part = 1.0;
        for evaluation in 0..SEARCHES {
            let here = slope_at(part);
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
        v.iter_mut().zip(&*direction).for_each(|(v, d)| *v += part * d);
    }
}

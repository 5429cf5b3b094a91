//! An interior-point method in the rates of the trees: the way where Newton's method stalls, for hundreds of contacts at once.
//!
//! ```text
//!     cone        r̃ = (μ r_N, r_T),   z̃ = (y_N/μ + |y_T|, y_T),   r̃ ∘ z̃ = ν (1, 0, 0)        ∘: the product of Jordan
//!     interval    (r − lower) p = ν,  (upper − r) q = ν,   y = p − q
//!     all         y = H v + b + c r,  M̃ (v − v_f) = Hᵀ r,   ν → 0
//! ```
//!
//! The products are taken after the scaling of Nesterov and Todd, `W z̃ = W⁻¹ r̃`, which keeps them equal to rounding however near the cones' borders
//! are. One iteration linearises a block as `P δy + Q δr = g`, so that `δr = K⁻¹(g − P off) − S H δv` with `K = Q + P (c + ε/ρ)`, `S = K⁻¹ P` and the
//! defect `off = H v + b + c r − y`. The matrix `M̃ + Σ Hᵀ S H` has the places of that of `newton.rs`; it is factored once and solved twice: for ν = 0,
//! which says how far ν may fall, and with the terms of second order (Mehrotra). The start are the impulses of nearly rigid sticking, lifted into the
//! cones, with equal products. Lengths are measured in `√ρ u` and `r/√ρ`.
//!
//! Source: S. J. Wright, Primal-Dual Interior-Point Methods, SIAM 1997, chapter 10; Y. E. Nesterov, M. J. Todd (1997) as in `jordan.rs`; the shift of
//! G. De Saxcé is in z̃ and in its derivative.

use crate::jordan::{arrow, scaling, to_border};
use crate::laws::Law;
use crate::newton::Workspace;
use crate::problem::{Block, Problem};
use crate::stall::Stall;
use nalgebra::{Matrix3, Vector3};

/// Most iterations.
const ITERATIONS: usize = 50;
/// ν and the defects below this part of their sizes are small enough for Newton's method.
const ENOUGH: f64 = 1e-10;
/// ε: keeps blocks apart that always hold.
const COMPLIANCE: f64 = 1e-10;
/// The same of sticking at the start.
const STIFF: f64 = 0.1;
/// Part of the way to the border of the cones, and the shortest step.
const SHORT: f64 = 0.99;
const SHORTEST: f64 = 1e-6;
/// ν that has not halved in this many iterations will not.
const STALLED: usize = 4;

/// An iterate, or a step.
#[derive(Clone, Default)]
struct Point {
    /// r (N s).
    impulses: Vec<Vector3<f64>>,
    /// y [m/s].
    rates: Vec<Vector3<f64>>,
    /// p and q of intervals [m/s].
    pushes: Vec<[f64; 2]>,
}

/// The linear equations of a block.
struct Linear {
    /// P.
    by_rate: Matrix3<f64>,
    /// K⁻¹.
    inverse: Matrix3<f64>,
    /// S, by rows.
    slope: [[f64; 3]; 3],
    /// g for ν = 0, and what ν adds to it.
    right: Vector3<f64>,
    by_product: Vector3<f64>,
}

/// Replaces impulses by ones near a solution; `false` if that fails. `depth` says how far inside the cones it starts, in units of the largest bias.
pub(crate) fn interior(problem: &Problem, impulses: &mut [Vector3<f64>], depth: f64, room: &mut Workspace) -> bool {
    let size = size_of(problem);
    let Some(mut point) = start(problem, depth, size, room) else { return false };
    let first = product(problem, &point);
    let mut v = Vec::new();
    let mut stall = Stall::new(first);
    for _ in 0..ITERATIONS {
        if room.is_interrupted() {
            return false;
        }
        problem.velocity(&point.impulses, &mut v);
        let rates = |number: usize| problem.rate(number, &v, &point.impulses[number]) - point.rates[number];
        let off: Vec<Vector3<f64>> = (0..problem.blocks.len()).map(rates).collect();
        let mean = product(problem, &point);
        let weighted = problem.blocks.iter().zip(&off).map(|(block, off)| block.rho.sqrt() * off.amax());
        let infeasible = weighted.fold(0.0, f64::max);
        stall.see(mean);
        if !mean.is_finite()
            || stall.lasts(STALLED)
            || (mean <= ENOUGH * first.min(size * size) && infeasible <= ENOUGH * size)
        {
            break;
        }
        let linear: Option<Vec<Linear>> =
            (0..problem.blocks.len()).map(|number| linear(&problem.blocks[number], number, &point)).collect();
        let Some(blocks) = linear else { break };
        room.iterations += 1;
        problem.begin_matrix(&mut room.factors);
        for (number, block) in blocks.iter().enumerate() {
            problem.add_to_matrix(number, &block.slope, &mut room.factors);
        }
        room.factors.factor(&problem.pattern);
        let straight = step(problem, &point, &blocks, &off, 0.0, None, room);
        let length = longest(problem, &point, &straight);
        let reached = product(problem, &moved(&point, &straight, length));
        let target = mean * (reached / mean).max(0.0).powi(2).min(1.0);
        let chosen = step(problem, &point, &blocks, &off, target, Some(&straight), room);
        let length = (SHORT * longest(problem, &point, &chosen)).min(1.0);
        if !length.is_finite() || length < SHORTEST {
            break;
        }
        point = moved(&point, &chosen, length);
    }
    let finite = point.impulses.iter().all(|impulse| impulse.iter().all(|entry| entry.is_finite()));
    if finite {
        impulses.copy_from_slice(&point.impulses);
    }
    finite
}

/// The largest bias with the rates without impulses, as √ρ u.
fn size_of(problem: &Problem) -> f64 {
    let none = Vector3::zeros();
    let size = |number: usize| problem.rate(number, &problem.free, &none).amax() * problem.blocks[number].rho.sqrt();
    (0..problem.blocks.len()).map(size).fold(f64::MIN_POSITIVE, f64::max)
}

/// Friction of a cone.
fn friction(block: &Block) -> Option<f64> {
    match block.law {
        Law::Cone(friction) => Some(friction),
        Law::Interval(..) => None,
    }
}

/// How far an impulse is from the bounds of an interval, which are apart; infinite for a side without bound, and on both for a given impulse.
fn bounds(block: &Block, impulse: f64) -> [f64; 2] {
    match block.law {
        Law::Interval(lower, upper) if lower < upper => [impulse - lower, upper - impulse],
        _ => [f64::INFINITY; 2],
    }
}

/// The first iterate.
fn start(problem: &Problem, depth: f64, size: f64, room: &mut Workspace) -> Option<Point> {
    let count = problem.blocks.len();
    let stiffness = |block: &Block| 1.0 / (STIFF / block.rho + block.compliance);
    let none = Vector3::zeros();
    let free: Vec<Vector3<f64>> = (0..count).map(|number| problem.rate(number, &problem.free, &none)).collect();
    let Workspace { factors, direction, .. } = room;
    problem.begin_matrix(factors);
    direction.clear();
    direction.resize(problem.free.len(), 0.0);
    for (number, block) in problem.blocks.iter().enumerate() {
        let stiff = stiffness(block);
        let slope = [[stiff, 0.0, 0.0], [0.0, stiff, 0.0], [0.0, 0.0, stiff]];
        problem.add_to_matrix(number, &slope, factors);
        problem.spread(number, &(free[number] * -stiff), direction);
    }
    factors.factor(&problem.pattern);
    factors.solve(&problem.pattern, direction);
    let mut point = Point::default();
    let product = depth.sqrt() * size * size;
    for (number, block) in problem.blocks.iter().enumerate() {
        let mut impulse = (problem.moved(number, direction) + free[number]) * -stiffness(block);
        let least = depth * size * block.rho.sqrt();
        let (mut rate, mut pushes) = (Vector3::zeros(), [0.0; 2]);
        match block.law {
            Law::Cone(friction) => {
                let across = impulse.y.hypot(impulse.z);
                impulse.x = impulse.x.max(across / friction) + least;
                // The inverse of r̃ times the product: (r̃₀, −r̃_T)/det.
                let lifted = friction * impulse.x;
                let factor = product / ((lifted - across) * (lifted + across));
                rate = Vector3::new(friction * (lifted - across), -impulse.y, -impulse.z) * factor;
            }
            Law::Interval(lower, upper) if lower < upper => {
                let within = (0.25 * (upper - lower)).min(least).max(f64::MIN_POSITIVE);
                impulse = Vector3::new(impulse.x.max(lower + within).min(upper - within), 0.0, 0.0);
                pushes = bounds(block, impulse.x).map(|room| if room.is_finite() { product / room } else { 0.0 });
                rate.x = pushes[0] - pushes[1];
            }
            Law::Interval(given, _) => impulse = Vector3::new(given, 0.0, 0.0),
        }
        point.impulses.push(impulse);
        point.rates.push(rate);
        point.pushes.push(pushes);
    }
    let finite = point.rates.iter().all(|rate| rate.iter().all(|entry| entry.is_finite()));
    finite.then_some(point)
}

/// The mean of all products: ν (J).
fn product(problem: &Problem, point: &Point) -> f64 {
    let (mut sum, mut number) = (0.0, 0.0_f64);
    for (place, block) in problem.blocks.iter().enumerate() {
        let (impulse, rate) = (&point.impulses[place], &point.rates[place]);
        if let Some(friction) = friction(block) {
            let slip = friction * impulse.x * rate.y.hypot(rate.z) + impulse.y * rate.y + impulse.z * rate.z;
            (sum, number) = (sum + impulse.x * rate.x + slip, number + 1.0);
            continue;
        }
        for (room, push) in bounds(block, impulse.x).into_iter().zip(&point.pushes[place]) {
            if room.is_finite() {
                (sum, number) = (sum + room * push, number + 1.0);
            }
        }
    }
    sum / number.max(1.0)
}

/// r̃, z̃ and ∂z̃/∂y of a cone.
fn lifted(friction: f64, impulse: &Vector3<f64>, rate: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>, Matrix3<f64>) {
    let slip = rate.y.hypot(rate.z);
    let mut slope = Matrix3::identity();
    slope[(0, 0)] = 1.0 / friction;
    if slip > 0.0 {
        (slope[(0, 1)], slope[(0, 2)]) = (rate.y / slip, rate.z / slip);
    }
    (lift(friction, impulse), Vector3::new(rate.x / friction + slip, rate.y, rate.z), slope)
}

/// r̃.
fn lift(friction: f64, impulse: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(friction * impulse.x, impulse.y, impulse.z)
}

/// The linear equations of a block; `None` if they have no solution.
fn linear(block: &Block, number: usize, point: &Point) -> Option<Linear> {
    let (impulse, rate) = (&point.impulses[number], &point.rates[number]);
    let mut softness = Vector3::repeat(COMPLIANCE / block.rho);
    softness.x += block.compliance;
    let (mut by_force, mut by_rate) = (Matrix3::identity(), Matrix3::zeros());
    let (mut right, mut by_product) = (Vector3::zeros(), Vector3::zeros());
    if let Some(friction) = friction(block) {
        let (force, lifted_rate, slope) = lifted(friction, impulse, rate);
        let [scale, back] = scaling(&force, &lifted_rate);
        let even = scale * lifted_rate;
        by_rate = arrow(&even) * scale * slope;
        by_force = arrow(&even) * back * Matrix3::from_diagonal(&Vector3::new(friction, 1.0, 1.0));
        right = -arrow(&even) * even;
        by_product.x = 1.0;
    } else {
        let rooms = bounds(block, impulse.x);
        if rooms.iter().any(|room| room.is_finite()) {
            (by_rate[(0, 0)], by_force[(0, 0)], right.x) = (1.0, 0.0, -rate.x);
            for ((room, push), sign) in rooms.into_iter().zip(point.pushes[number]).zip([1.0, -1.0]) {
                if room.is_finite() {
                    by_force[(0, 0)] += push / room;
                    by_product.x += sign / room;
                }
            }
        }
    }
    let inverse = (by_force + by_rate * Matrix3::from_diagonal(&softness)).try_inverse()?;
    let slope = inverse * by_rate;
    let slope = [0, 1, 2].map(|row| [slope[(row, 0)], slope[(row, 1)], slope[(row, 2)]]);
    Some(Linear { by_rate, inverse, slope, right, by_product })
}

/// The step of all variables towards products ν, with the terms of second order of an earlier step.
fn step(
    problem: &Problem,
    point: &Point,
    blocks: &[Linear],
    off: &[Vector3<f64>],
    target: f64,
    earlier: Option<&Point>,
    room: &mut Workspace,
) -> Point {
    let Workspace { factors, direction, .. } = room;
    direction.clear();
    direction.resize(problem.free.len(), 0.0);
    let mut step = Point::default();
    for (number, linear) in blocks.iter().enumerate() {
        let second = earlier.map_or(Vector3::zeros(), |earlier| second_order(problem, number, point, earlier));
        let right = linear.right + linear.by_product * target - second - linear.by_rate * off[number];
        let pushed = linear.inverse * right;
        problem.spread(number, &pushed, direction);
        step.impulses.push(pushed);
    }
    factors.solve(&problem.pattern, direction);
    for (number, (block, linear)) in problem.blocks.iter().zip(blocks).enumerate() {
        let mut turn = problem.moved(number, direction);
        let impulse = &mut step.impulses[number];
        for (entry, row) in impulse.iter_mut().zip(&linear.slope) {
            *entry -= row[0] * turn.x + row[1] * turn.y + row[2] * turn.z;
        }
        turn.x += block.compliance * impulse.x;
        step.rates.push(turn + off[number]);
        let mut change = [0.0; 2];
        for (side, (room, sign)) in bounds(block, point.impulses[number].x).into_iter().zip([1.0, -1.0]).enumerate() {
            if room.is_finite() {
                let push = point.pushes[number][side];
                let second = earlier.map_or(0.0, |step| sign * step.impulses[number].x * step.pushes[number][side]);
                change[side] = (target - second - sign * push * impulse.x) / room - push;
            }
        }
        step.pushes.push(change);
    }
    step
}

/// The terms of second order of a step in the equations of a block.
fn second_order(problem: &Problem, number: usize, point: &Point, step: &Point) -> Vector3<f64> {
    let block = &problem.blocks[number];
    let (impulse, rate) = (&point.impulses[number], &point.rates[number]);
    if let Some(friction) = friction(block) {
        let (force, lifted_rate, slope) = lifted(friction, impulse, rate);
        let [scale, back] = scaling(&force, &lifted_rate);
        return arrow(&(back * lift(friction, &step.impulses[number]))) * (scale * slope * step.rates[number]);
    }
    // Both bounds: (δr δp)/room and −(−δr δq)/room.
    let rooms = bounds(block, impulse.x).into_iter().zip(step.pushes[number]).filter(|(room, _)| room.is_finite());
    Vector3::new(rooms.map(|(room, push)| step.impulses[number].x * push / room).sum(), 0.0, 0.0)
}

/// A point after a part of a step.
fn moved(point: &Point, step: &Point, length: f64) -> Point {
    let along = |from: &[Vector3<f64>], by: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
        from.iter().zip(by).map(|(from, by)| from + by * length).collect()
    };
    let pushes = point.pushes.iter().zip(&step.pushes);
    Point {
        impulses: along(&point.impulses, &step.impulses),
        rates: along(&point.rates, &step.rates),
        pushes: pushes.map(|(from, by)| [from[0] + length * by[0], from[1] + length * by[1]]).collect(),
    }
}

/// The longest part of a step, at most 1, to the border of the cones.
fn longest(problem: &Problem, point: &Point, step: &Point) -> f64 {
    let mut length = 1.0_f64;
    let mut positive = |value: f64, change: f64| {
        if change < 0.0 && value.is_finite() {
            length = length.min(-value / change);
        }
    };
    for (number, block) in problem.blocks.iter().enumerate() {
        let (impulse, change) = (&point.impulses[number], &step.impulses[number]);
        if let Some(friction) = friction(block) {
            positive(impulse.x, change.x);
            positive(point.rates[number].x, step.rates[number].x);
            positive(1.0, -1.0 / to_border(&lift(friction, impulse), &lift(friction, change)));
            continue;
        }
        for (side, (room, sign)) in bounds(block, impulse.x).into_iter().zip([1.0, -1.0]).enumerate() {
            positive(room, sign * change.x);
            if room.is_finite() {
                positive(point.pushes[number][side], step.pushes[number][side]);
            }
        }
    }
    length
}

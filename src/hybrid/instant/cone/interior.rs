//! An interior-point method with De Saxcé's shift in its Newton matrix: the start of Newton's method where sweeps lead astray.
//!
//! ```text
//!     contact     r̃ = (μ r_N, r_T),   z̃ = (y_N/μ + |y_T|, y_T),   r̃ ∘ z̃ = ν (1, 0, 0)        ∘: the product of Jordan,  z̃ in its cone ⇔ y_N ≥ 0
//!     interval    (r − lower) p = ν,  (upper − r) q = ν,   y = p − q
//!     sliding     r_N y_N = ν,        r_T = −μ r_N t
//!     all         y = D r + b,        ν → 0
//! ```
//!
//! Each iteration solves `(Q + P D) δr = c − P (D r + b − y)` twice, P = ∂/∂y and Q = ∂/∂r of the left sides: once for ν = 0, which says how far ν
//! may fall, and once with the terms of second order (Mehrotra). It starts from the forces of nearly rigid sticking, lifted into the cones, with all
//! products equal, and ends at 1e-8.
//!
//! Source: S. J. Wright, Primal-Dual Interior-Point Methods, SIAM 1997, chapter 10.

use crate::crowd::jordan::{arrow, to_border};
use crate::instant::cone::problem::Law;
use crate::instant::cone::scaled::Scaled;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Most iterations.
const ITERATIONS: usize = 50;
/// ν and `D r + b − y` below this part of their sizes are small enough for Newton's method.
const ENOUGH: f64 = 1e-8;
/// Compliance that keeps rows apart that always hold.
const COMPLIANCE: f64 = 1e-10;
/// Compliance of sticking at the start.
const STIFF: f64 = 0.1;
/// Part of the way to the border of the cones.
const SHORT: f64 = 0.99;

/// An iterate.
#[derive(Clone)]
struct Point {
    /// r (m).
    forces: Vec<f64>,
    /// y (m).
    rates: Vec<f64>,
    /// p and q of intervals.
    pushes: Vec<[f64; 2]>,
}

/// A block of the Newton matrix.
struct Linear {
    /// P.
    by_rate: Matrix3<f64>,
    /// Q.
    by_force: Matrix3<f64>,
    /// c for ν = 0 and what ν adds to it.
    right: Vector3<f64>,
    by_product: Vector3<f64>,
}

/// Scaled forces near a solution; `None` if it fails. Spread says how far inside the cones it starts, in units of the largest b.
pub(super) fn interior(problem: &Scaled, spread: f64) -> Option<Vec<f64>> {
    let mut point = start(problem, spread)?;
    let count = problem.free.len();
    let size = problem.free.iter().fold(0.0_f64, |most, free| most.max(free.abs()));
    let mut off = vec![0.0; count];
    let first = product(problem, &point);
    for _ in 0..ITERATIONS {
        problem.rates(&point.forces, &mut off);
        off.iter_mut().zip(&point.rates).for_each(|(off, rate)| *off -= rate);
        let mean = product(problem, &point);
        let infeasible = off.iter().fold(0.0_f64, |most, off| most.max(off.abs()));
        if !mean.is_finite() || (mean <= ENOUGH * first.min(size * size) && infeasible <= ENOUGH * size) {
            break;
        }
        let blocks: Vec<Linear> =
            problem.blocks().zip(&point.pushes).map(|((row, law), pushes)| linear(&law, row, &point, pushes)).collect();
        let factors = matrix(problem, &blocks).lu();
        let solve = |right: &dyn Fn(usize) -> Vector3<f64>| {
            let mut sides = DVector::zeros(count);
            for (block, (start, law)) in problem.blocks().enumerate() {
                let side = right(block) - blocks[block].by_rate * padded(&law, &off[start..]);
                sides.rows_mut(start, law.rows()).copy_from(&side.rows(0, law.rows()));
            }
            let forces = factors.solve(&sides)?;
            let mut rates = vec![0.0; count];
            for (column, &force) in forces.iter().enumerate() {
                problem.add_column(column, force, &mut rates);
            }
            rates.iter_mut().zip(&off).for_each(|(rate, off)| *rate += off);
            Some((forces.data.into(), rates))
        };
        let (forces, rates): (Vec<f64>, Vec<f64>) = solve(&|block| blocks[block].right)?;
        let straight = step(problem, &point, &forces, &rates, 0.0, None);
        let length = longest(problem, &point, &straight);
        let reached = product(problem, &moved(&point, &straight, length));
        let target = mean * (reached / mean).max(0.0).powi(3).min(1.0);
        let corrected: Vec<Vector3<f64>> = problem
            .blocks()
            .enumerate()
            .map(|(block, (row, law))| second_order(&law, row, &point, &straight, block))
            .collect();
        let right = |block: usize| blocks[block].right + blocks[block].by_product * target - corrected[block];
        let (forces, rates): (Vec<f64>, Vec<f64>) = solve(&right)?;
        let chosen = step(problem, &point, &forces, &rates, target, Some(&straight));
        let length = (SHORT * longest(problem, &point, &chosen)).min(1.0);
        if !length.is_finite() || length < 1e-6 {
            break;
        }
        point = moved(&point, &chosen, length);
    }
    point.forces.iter().all(|force| force.is_finite()).then_some(point.forces)
}

/// The rows of a block, with zeros for those that it does not have.
fn padded(law: &Law, values: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|row, _| if row < law.rows() { values[row] } else { 0.0 })
}

/// Friction of a contact that has any.
fn coulomb(law: &Law) -> Option<f64> {
    match *law {
        Law::Contact { friction } if friction > 0.0 => Some(friction),
        _ => None,
    }
}

/// The first iterate.
fn start(problem: &Scaled, spread: f64) -> Option<Point> {
    let count = problem.free.len();
    let sticking = problem.softened(STIFF).mobility.lu().solve(&-DVector::from_column_slice(&problem.free))?;
    let size = problem.free.iter().fold(0.0_f64, |most, free| most.max(free.abs())).max(f64::MIN_POSITIVE);
    let mut point = Point { forces: sticking.data.into(), rates: vec![0.0; count], pushes: Vec::new() };
    let least = spread * size;
    let product = spread.sqrt() * size * size;
    for (start, law) in problem.blocks() {
        let mut pushes = [0.0; 2];
        let forces = &mut point.forces[start..start + law.rows()];
        let rates = &mut point.rates[start..start + law.rows()];
        match law {
            Law::Interval { lower, upper } => {
                let room = (0.25 * (upper - lower)).min(least).max(f64::MIN_POSITIVE);
                forces[0] = forces[0].max(lower + room).min(upper - room);
                let bounds = [forces[0] - lower, upper - forces[0]];
                pushes = bounds.map(|room| if room.is_finite() { product / room } else { 0.0 });
                rates[0] = pushes[0] - pushes[1];
            }
            Law::Contact { friction } if friction > 0.0 => {
                let tangential = forces[1].hypot(forces[2]);
                forces[0] = forces[0].max(tangential / friction) + least;
                // The inverse of r̃ times the product: (r̃₀, −r̃_T)/det.
                let lifted = friction * forces[0];
                let determinant = lifted * lifted - tangential * tangential;
                let factor = product / determinant;
                (rates[1], rates[2]) = (-factor * forces[1], -factor * forces[2]);
                rates[0] = friction * factor * (lifted - tangential);
            }
            Law::Contact { .. } | Law::Sliding { .. } => {
                forces[0] = forces[0].max(0.0) + least;
                rates[0] = product / forces[0];
                let (friction, [x, y]) = known_friction(&law);
                (forces[1], forces[2]) = (-friction * forces[0] * x, -friction * forces[0] * y);
            }
        }
        point.pushes.push(pushes);
    }
    Some(point)
}

/// Friction with a known direction; zero without friction.
fn known_friction(law: &Law) -> (f64, [f64; 2]) {
    match *law {
        Law::Sliding { friction, direction } => (friction, direction),
        _ => (0.0, [0.0; 2]),
    }
}

/// The mean of all products: ν.
fn product(problem: &Scaled, point: &Point) -> f64 {
    let (mut sum, mut number) = (0.0, 0.0_f64);
    for ((start, law), pushes) in problem.blocks().zip(&point.pushes) {
        let (forces, rates) = (&point.forces[start..], &point.rates[start..]);
        match law {
            Law::Interval { lower, upper } => {
                for (room, push) in [forces[0] - lower, upper - forces[0]].into_iter().zip(pushes) {
                    if room.is_finite() {
                        (sum, number) = (sum + room * push, number + 1.0);
                    }
                }
            }
            _ => {
                let slip = coulomb(&law).map_or(0.0, |friction| {
                    friction * forces[0] * rates[1].hypot(rates[2]) + forces[1] * rates[1] + forces[2] * rates[2]
                });
                (sum, number) = (sum + forces[0] * rates[0] + slip, number + 1.0);
            }
        }
    }
    sum / number.max(1.0)
}

/// r̃, z̃ and ∂z̃/∂y of a contact.
fn lifted(friction: f64, start: usize, point: &Point) -> (Vector3<f64>, Vector3<f64>, Matrix3<f64>) {
    let (forces, rates) = (&point.forces[start..start + 3], &point.rates[start..start + 3]);
    let slip = rates[1].hypot(rates[2]);
    let mut slope = Matrix3::identity();
    slope[(0, 0)] = 1.0 / friction;
    if slip > 0.0 {
        (slope[(0, 1)], slope[(0, 2)]) = (rates[1] / slip, rates[2] / slip);
    }
    let force = Vector3::new(friction * forces[0], forces[1], forces[2]);
    (force, Vector3::new(rates[0] / friction + slip, rates[1], rates[2]), slope)
}

/// The linear equations of a block.
fn linear(law: &Law, start: usize, point: &Point, pushes: &[f64; 2]) -> Linear {
    let (force, rate) = (point.forces[start], point.rates[start]);
    let mut found = Linear {
        by_rate: Matrix3::zeros(),
        by_force: Matrix3::zeros(),
        right: Vector3::zeros(),
        by_product: Vector3::zeros(),
    };
    match *law {
        Law::Interval { lower, upper } => {
            found.by_rate[(0, 0)] = 1.0;
            found.right.x = -rate;
            for (room, push, sign) in [(force - lower, pushes[0], 1.0), (upper - force, pushes[1], -1.0)] {
                if room.is_finite() {
                    found.by_force[(0, 0)] += push / room;
                    found.by_product.x += sign / room;
                }
            }
        }
        Law::Contact { friction } if friction > 0.0 => {
            let (lifted_force, lifted_rate, slope) = lifted(friction, start, point);
            found.by_rate = arrow(&lifted_force) * slope;
            found.by_force = arrow(&lifted_rate) * Matrix3::from_diagonal(&Vector3::new(friction, 1.0, 1.0));
            found.right = -arrow(&lifted_force) * lifted_rate;
            found.by_product.x = 1.0;
        }
        Law::Contact { .. } | Law::Sliding { .. } => {
            let (friction, along) = known_friction(law);
            (found.by_rate[(0, 0)], found.by_force[(0, 0)]) = (force, rate);
            (found.right.x, found.by_product.x) = (-force * rate, 1.0);
            for (row, along) in [(1, along[0]), (2, along[1])] {
                found.by_force[(row, row)] = 1.0;
                found.by_force[(row, 0)] = friction * along;
                found.right[row] = -(point.forces[start + row] + friction * force * along);
            }
        }
    }
    found
}

/// `Q + P (D + ε)`.
fn matrix(problem: &Scaled, blocks: &[Linear]) -> DMatrix<f64> {
    let mut matrix = problem.softened(COMPLIANCE).mobility;
    for ((start, law), block) in problem.blocks().zip(blocks) {
        let rows = law.rows();
        for mut column in matrix.column_iter_mut() {
            let product = block.by_rate * padded(&law, &column.as_slice()[start..]);
            column.rows_mut(start, rows).copy_from(&product.rows(0, rows));
        }
        let mut corner = matrix.view_mut((start, start), (rows, rows));
        corner += block.by_force.view((0, 0), (rows, rows));
    }
    matrix
}

/// The step of all variables for the steps of forces and rates, with the products of an earlier step.
fn step(problem: &Scaled, point: &Point, forces: &[f64], rates: &[f64], target: f64, earlier: Option<&Point>) -> Point {
    let mut pushes = Vec::with_capacity(point.pushes.len());
    for (block, (start, law)) in problem.blocks().enumerate() {
        let mut change = [0.0; 2];
        if let Law::Interval { lower, upper } = law {
            let rooms = [point.forces[start] - lower, upper - point.forces[start]];
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                if rooms[side].is_finite() {
                    let push = point.pushes[block][side];
                    let second =
                        earlier.map_or(0.0, |earlier| sign * earlier.forces[start] * earlier.pushes[block][side]);
                    change[side] = (target - second - sign * push * forces[start]) / rooms[side] - push;
                }
            }
        }
        pushes.push(change);
    }
    Point { forces: forces.to_vec(), rates: rates.to_vec(), pushes }
}

/// The terms of second order of a step in the equations of a block.
fn second_order(law: &Law, start: usize, point: &Point, step: &Point, block: usize) -> Vector3<f64> {
    match *law {
        Law::Interval { lower, upper } => {
            let rooms = [point.forces[start] - lower, upper - point.forces[start]];
            let term = |side: usize| {
                if rooms[side].is_finite() { step.forces[start] * step.pushes[block][side] / rooms[side] } else { 0.0 }
            };
            // Both bounds: (δr δp)/room and −(−δr δq)/room.
            Vector3::new(term(0) + term(1), 0.0, 0.0)
        }
        Law::Contact { friction } if friction > 0.0 => {
            let slope = lifted(friction, start, point).2;
            let force = Vector3::new(friction * step.forces[start], step.forces[start + 1], step.forces[start + 2]);
            arrow(&force) * slope * Vector3::from_column_slice(&step.rates[start..start + 3])
        }
        Law::Contact { .. } | Law::Sliding { .. } => Vector3::new(step.forces[start] * step.rates[start], 0.0, 0.0),
    }
}

/// A point after a part of a step.
fn moved(point: &Point, step: &Point, length: f64) -> Point {
    let advance =
        |from: &[f64], by: &[f64]| from.iter().zip(by).map(|(from, by)| from + length * by).collect::<Vec<f64>>();
    let pushes = point.pushes.iter().zip(&step.pushes);
    Point {
        forces: advance(&point.forces, &step.forces),
        rates: advance(&point.rates, &step.rates),
        pushes: pushes.map(|(from, by)| [from[0] + length * by[0], from[1] + length * by[1]]).collect(),
    }
}

/// The longest part of a step, at most 1, to the border of the cones.
fn longest(problem: &Scaled, point: &Point, step: &Point) -> f64 {
    let mut length = 1.0_f64;
    let mut positive = |value: f64, change: f64| {
        if change < 0.0 && value.is_finite() {
            length = length.min(-value / change);
        }
    };
    for (block, (start, law)) in problem.blocks().enumerate() {
        match law {
            Law::Interval { lower, upper } => {
                let force = point.forces[start];
                for (side, room, sign) in [(0, force - lower, 1.0), (1, upper - force, -1.0)] {
                    positive(room, sign * step.forces[start]);
                    positive(point.pushes[block][side], step.pushes[block][side]);
                }
            }
            _ => {
                positive(point.forces[start], step.forces[start]);
                positive(point.rates[start], step.rates[start]);
                if let Some(friction) = coulomb(&law) {
                    let lift = |of: &Point| {
                        Vector3::new(friction * of.forces[start], of.forces[start + 1], of.forces[start + 2])
                    };
                    positive(1.0, -1.0 / to_border(&lift(point), &lift(step)));
                }
            }
        }
    }
    length
}

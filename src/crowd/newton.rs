//! Newton's method for the problem of an island in the rates of its trees.
//!
//! ```text
//!     F_k + A_k H_k dv + B_k dr_k = 0,   B_k ← B_k + (ε/ρ_k) A_k          ε = clamp(residual, 1e-8, 0.1)
//!     (M̃ + Σ H_kᵀ B_k⁻¹ A_k H_k) dv = −Σ H_kᵀ B_k⁻¹ F_k                    one LU factorisation an iteration
//! ```
//!
//! ε is a proximal part: without it contacts that stick at places that do not fit together have no bounded impulses. A step is halved until the sum of
//! the squared natural maps falls. If five halvings do not help, the full step is taken, a few times at most. The best impulses of all iterations are the answer.
//!
//! Source: P. Alart, A. Curnier (1991), as in `laws.rs`; A. M. Castro, F. N. Permenter, X. Han, An unconstrained convex formulation of compliant
//! contact, IEEE Transactions on Robotics 39 (2023) for the sparsity.

use crate::block_factors::Factors;
use crate::problem::Problem;
use nalgebra::{Matrix3, Vector3};

/// The proximal part lies between these.
const PROXIMAL: [f64; 2] = [1e-8, 0.1];
/// The merit has to fall to this part at a step that counts as a success.
const FALLS: f64 = 0.9;
const HALVINGS: usize = 5;
/// Full steps without success are taken this often in a row, if the merit grows by this factor at most.
const UNSUCCESSFUL: usize = 3;
const GROWS: f64 = 100.0;

/// Room for the iterations of any island, and their count.
#[derive(Clone, Default)]
pub struct Workspace {
    pub factors: Factors,
    pub iterations: usize,
    direction: Vec<f64>,
    parts: Vec<(Vector3<f64>, Matrix3<f64>)>,
    trial: Vec<Vector3<f64>>,
    best: Vec<Vector3<f64>>,
    moved: Vec<f64>,
}

/// Iterates on impulses and rates until the residual is below `tolerance`, with a largest number of iterations; returns the residual at the end.
pub fn newton(
    problem: &Problem,
    impulses: &mut [Vector3<f64>],
    v: &mut Vec<f64>,
    [tolerance, most]: [f64; 2],
    room: &mut Workspace,
) -> f64 {
    problem.velocity(impulses, v);
    let mut merit = problem.merit(impulses, v);
    let mut best = merit.residual;
    room.best.clear();
    room.best.extend_from_slice(impulses);
    let mut unsuccessful = 0;
    for _ in 0..most as usize {
        if merit.residual <= tolerance {
            break;
        }
        direction(problem, impulses, v, merit.residual, room);
        let (mut part, mut falls) = (1.0, false);
        let Workspace { parts, direction, trial, moved, .. } = room;
        let change = |number: usize| {
            let (shift, slope) = &parts[number];
            -shift - slope * problem.moved(number, direction)
        };
        let changes: Vec<Vector3<f64>> = (0..impulses.len()).map(change).collect();
        let mut found = merit;
        for _ in 0..HALVINGS {
            trial.clear();
            trial.extend(impulses.iter().zip(&changes).map(|(impulse, change)| impulse + change * part));
            problem.velocity(trial, moved);
            found = problem.merit(trial, moved);
            if found.value.is_finite() && found.value < FALLS * merit.value {
                falls = true;
                break;
            }
            part *= 0.5;
        }
        if !falls {
            trial.clear();
            trial.extend(impulses.iter().zip(&changes).map(|(impulse, change)| impulse + change));
            problem.velocity(trial, moved);
            found = problem.merit(trial, moved);
        }
        if !found.value.is_finite() || (!falls && found.value > GROWS * merit.value) {
            break;
        }
        unsuccessful = if falls { 0 } else { unsuccessful + 1 };
        impulses.copy_from_slice(trial);
        std::mem::swap(v, moved);
        merit = found;
        if merit.residual < best {
            best = merit.residual;
            room.best.copy_from_slice(impulses);
        }
        if unsuccessful >= UNSUCCESSFUL {
            break;
        }
    }
    if best < merit.residual || merit.residual.is_nan() {
        impulses.copy_from_slice(&room.best);
        problem.velocity(impulses, v);
    }
    best
}

/// The direction dv, and B⁻¹F and B⁻¹A of each block.
fn direction(problem: &Problem, impulses: &[Vector3<f64>], v: &[f64], residual: f64, room: &mut Workspace) {
    let Workspace { factors, direction, parts, iterations, .. } = room;
    *iterations += 1;
    direction.clear();
    direction.resize(v.len(), 0.0);
    parts.clear();
    problem.begin_matrix(factors);
    for (number, block) in problem.blocks.iter().enumerate() {
        let rate = problem.rate(number, v, &impulses[number]);
        let mut linear = block.law.linearise(&impulses[number], &rate, block.rho);
        let proximal = residual.clamp(PROXIMAL[0], PROXIMAL[1]) / block.rho;
        let along = linear.by_rate * Vector3::new(block.compliance, 0.0, 0.0);
        linear.by_impulse += linear.by_rate * proximal;
        for row in 0..3 {
            linear.by_impulse[(row, 0)] += along[row];
        }
        let (shift, slope) = if block.law.rows() == 1 {
            let by_impulse = linear.by_impulse[(0, 0)];
            let shift = Vector3::new(linear.value.x / by_impulse, 0.0, 0.0);
            (shift, Matrix3::from_diagonal(&Vector3::new(linear.by_rate[(0, 0)] / by_impulse, 0.0, 0.0)))
        } else {
            let inverse = linear.by_impulse.try_inverse().unwrap_or_else(Matrix3::identity);
            (inverse * linear.value, inverse * linear.by_rate)
        };
        problem.spread(number, &-shift, direction);
        if slope != Matrix3::zeros() {
            problem.add_to_matrix(number, &slope, factors);
        }
        parts.push((shift, slope));
    }
    factors.factor(&problem.pattern);
    factors.solve(&problem.pattern, direction);
}
